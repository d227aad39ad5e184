#pragma once

/// @file
/// Profiles of the parameters of a joint run, at the structure and the smoothness it chose: of the
/// rates (beta, tau_j, tau_h, i_0), and of r_s and r_j where they are one number. Everything else
/// is refitted, v_oc(A) too. Tests: tests/identify/joint/joint_profile_test.cc.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "identify/joint/joint_run.h"
#include "identify/trust/profile.h"

namespace lipoid {

/// Throws OptionError for names that no joint run of these options can profile, whatever it chooses.
void CheckJointProfile(const std::vector<std::string>& names,
                       const StagedGiven& given,
                       const JointOptions& options,
                       bool diffusion);

/// Names are those of the trust report: branches by rising time constant. `bounds` are those that
/// the run had. What this run does not have, what was given, and a table has no profile and a reason,
/// behind the others. Throws OptionError for what no joint run has.
[[nodiscard]] std::vector<Profile> ProfileJoint(
    const std::vector<std::string>& names,
    const JointResult& result,
    const TrustReport& trust,
    const std::map<std::string, std::pair<double, double>>& bounds = {});

}  // namespace lipoid
