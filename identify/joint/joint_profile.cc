#include "identify/joint/joint_profile.h"

#include <fmt/format.h>

#include <algorithm>

#include "identify/fit/fit_profile.h"
#include "model/core/errors.h"

namespace lipoid {

void CheckJointProfile(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (name == "alpha") {
      throw OptionError(
          "option --profile: alpha is a convention of the joint method and moves no voltage; "
          "see its interval in the report");
    }
    if (name.rfind("c_", 0) == 0) {
      throw OptionError(
          fmt::format("option --profile: the joint method knows branches by their time constants; "
                      "profile tau_{} instead of {}",
                      name.substr(2),
                      name));
    }
  }
}

std::vector<Profile> ProfileJoint(const std::vector<std::string>& names,
                                  const JointResult& result,
                                  const TrustReport& trust,
                                  const std::map<std::string, std::pair<double, double>>& bounds) {
  CheckJointProfile(names);
  const JointSolution& best = result.choice.best;
  const GivenParameters known{.fixed = result.fixed, .bounds = bounds};
  const Profiled offered = ProfiledNames(best.structure, result.setup.diffusion, false, known);
  for (const std::string& name : names) {
    if (std::find(offered.tables.begin(), offered.tables.end(), name) == offered.tables.end())
      continue;
    throw OptionError(
        fmt::format("option --profile: {} is a table over the state of charge here, and no single "
                    "value can be held; --set joint.resistance_nodes=1 makes it one number",
                    name));
  }
  CheckProfileNames(names, offered.free, offered.fixed);

  constexpr double kStep = 1e-3;  // what it leaves of the cost is its square
  const JointObservations seen(result.logs, result.setup);
  return ProfileFit(names,
                    {.seen = seen,
                     .solution = best,
                     .known = known,
                     .scales = seen.scales(),
                     .typical_Ohm = 0.1 / result.logs.typical_A,
                     .refit =
                         [](const JointFit& fit, JointSolution from) {
                           return fit.Polish(std::move(from), kStep);
                         }},
                    trust);
}

}  // namespace lipoid
