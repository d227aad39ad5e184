#pragma once

/// @file
/// What `lipoid identify --method joint` shows to people.

#include <string>

#include "identify/joint/joint_run.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// What was tried, what was found and how far to believe it, how well each log is predicted, what
/// to know.
[[nodiscard]] std::string JointReport(const JointResult& result, const TrustReport& trust);

}  // namespace lipoid
