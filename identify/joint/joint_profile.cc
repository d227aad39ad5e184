#include "identify/joint/joint_profile.h"

#include <fmt/format.h>

#include <algorithm>

#include "identify/fit/fit_profile.h"
#include "identify/joint/held_shape.h"
#include "model/core/errors.h"

namespace lipoid {

namespace {

void RefuseConventions(const std::vector<std::string>& names) {
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

// With every term that may be chosen, and as many branches.
JointStructure Richest(const StagedGiven& given, const JointOptions& options) {
  JointStructure structure;
  const auto has = [&](Presence presence, bool of_reference) {
    return given.reference ? of_reference : presence != Presence::kOff;
  };
  const Cell held = given.reference ? given.reference->cell : Cell();
  structure.branches = given.reference         ? static_cast<int>(held.branches.size())
                       : options.branches >= 0 ? options.branches
                                               : options.most_branches + 1;
  structure.self_heating = has(options.self_heating, held.self_heating.has_value());
  structure.charge_transfer = has(options.charge_transfer, held.charge_transfer.has_value());
  structure.temperature = has(options.temperature, held.temperature.has_value());
  if (has(options.hysteresis, held.hysteresis.has_value())) structure.hysteresis_soc = {0.5};
  return structure;
}

}  // namespace

void CheckJointProfile(const std::vector<std::string>& names,
                       const StagedGiven& given,
                       const JointOptions& options,
                       bool diffusion) {
  RefuseConventions(names);
  GivenParameters known = given.parameters;
  if (given.reference) known.fixed.merge(given.reference->Rates());
  JointStructure structure = Richest(given, options);
  Profiled offered;
  const auto add = [](const std::vector<std::string>& from, std::vector<std::string>& to) {
    for (const std::string& name : from) {
      if (std::find(to.begin(), to.end(), name) == to.end()) to.push_back(name);
    }
  };
  for (const SharedEnergies shared :
       {SharedEnergies::kNone, SharedEnergies::kAllButSeries, SharedEnergies::kAll}) {
    structure.shared_energies = shared;
    const Profiled one = ProfiledNames(structure, diffusion, false, known);
    add(one.free, offered.free);
    add(one.fixed, offered.fixed);
  }
  CheckProfileNames(names, offered.free, offered.fixed);
}

std::vector<Profile> ProfileJoint(const std::vector<std::string>& names,
                                  const JointResult& result,
                                  const TrustReport& trust,
                                  const std::map<std::string, std::pair<double, double>>& bounds) {
  RefuseConventions(names);
  const JointSolution& best = result.choice.best;
  const GivenParameters known{.fixed = result.fixed, .bounds = bounds};
  const Profiled offered = ProfiledNames(best.structure, result.setup.diffusion, false, known);
  const auto has = [](const std::vector<std::string>& list, const std::string& name) {
    return std::find(list.begin(), list.end(), name) != list.end();
  };
  std::vector<std::string> free;
  std::vector<Profile> none;
  for (const std::string& name : names) {
    if (has(offered.free, name)) {
      free.push_back(name);
      continue;
    }
    Profile one;
    one.name = name;
    one.unit = std::string(CellParameterUnit(name));
    one.none_because =
        has(offered.tables, name)
            ? "it is a table over the state of charge here, and no single value can be held; --set "
              "joint.resistance_nodes=1 makes it one number"
        : has(offered.fixed, name) ? "it is given, or follows from what is"
                                   : "the structure that was chosen does not have it";
    none.push_back(std::move(one));
  }

  constexpr double kStep = 1e-3;  // what it leaves of the cost is its square
  const JointObservations seen(result.logs, result.setup);
  std::vector<Profile> found = ProfileFit(free,
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
  found.insert(found.end(), none.begin(), none.end());
  return found;
}

}  // namespace lipoid
