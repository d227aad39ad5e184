#pragma once

/// @file
/// Profiles of the parameters of stage 3: beta, r_s, r_j, tau_j and c_j, with alpha and v_oc(A)
/// held as its fit holds them. Tests: tests/identify/stages/staged_profile_test.cc.

#include <string>
#include <vector>

#include "identify/stages/pulse_fit.h"
#include "identify/stages/start_values.h"
#include "identify/trust/profile.h"

namespace lipoid {

/// Throws OptionError for a name that this fit does not have, or that was given.
void CheckStagedProfile(const std::vector<std::string>& names,
                        const PulseFitOptions& options,
                        const GivenParameters& given);

/// Of what FitPulses found with these options in the logs of the sweep, whose `data` are the start
/// values. All rows take part; each point starts at its neighbour.
[[nodiscard]] std::vector<Profile> ProfileStaged(const std::vector<std::string>& names,
                                                 const VoltageSweep& sweep,
                                                 const StartValues& data,
                                                 const PulseFitResult& fit,
                                                 const TrustReport& trust,
                                                 const PulseFitOptions& options = {},
                                                 const LevenbergMarquardtOptions& solver = {},
                                                 const GivenParameters& given = {});

}  // namespace lipoid
