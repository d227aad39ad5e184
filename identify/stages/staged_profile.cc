#include "identify/stages/staged_profile.h"

#include "identify/fit/fit_profile.h"
#include "identify/stages/pulse_problem.h"

namespace lipoid {

void CheckStagedProfile(const std::vector<std::string>& names,
                        const PulseFitOptions& options,
                        const GivenParameters& given) {
  const Profiled offered =
      ProfiledNames({.branches = options.branches}, options.diffusion, true, given);
  CheckProfileNames(names, offered.free, offered.fixed);
}

std::vector<Profile> ProfileStaged(const std::vector<std::string>& names,
                                   const VoltageSweep& sweep,
                                   const StartValues& data,
                                   const PulseFitResult& fit,
                                   const TrustReport& trust,
                                   const PulseFitOptions& options,
                                   const LevenbergMarquardtOptions& solver,
                                   const GivenParameters& given) {
  CheckStagedProfile(names, options, given);
  return ProfileFit(names,
                    {.seen = sweep,
                     .solution = fit.solution,
                     .known = given,
                     .scales = PulseFitScales(sweep, data),
                     .typical_Ohm =
                         FindPulseScales(data, sweep.setup().alpha_C).series_resistance_Ohm,
                     .refit =
                         [&](const JointFit& held, JointSolution from) {
                           return held.Approach(std::move(from), solver);
                         }},
                    trust);
}

}  // namespace lipoid
