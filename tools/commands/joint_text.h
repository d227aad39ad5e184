#pragma once

/// @file
/// What `lipoid identify --method joint` shows to people.

#include <string>

#include "identify/joint/joint_run.h"

namespace lipoid {

/// What was tried, what was found, how well each log is predicted, what to know.
[[nodiscard]] std::string JointReport(const Campaign& campaign, const JointResult& result);

}  // namespace lipoid
