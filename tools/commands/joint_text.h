#pragma once

/// @file
/// What `lipoid identify --method joint` shows to people.

#include <string>

#include "identify/joint/joint_run.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// How well each log is predicted, the parameters with their uncertainty, fallbacks and caveats.
/// `verbose`: before these the structures that were tried and the tables that were found.
[[nodiscard]] std::string JointReport(const JointResult& result,
                                      const TrustReport& trust,
                                      bool verbose);

}  // namespace lipoid
