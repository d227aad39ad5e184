#include "identify/joint/joint_request.h"

#include <fmt/format.h>

#include <string_view>
#include <utility>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// Without --branches the data say how many there are, and none has a name.
void CheckParameters(const GivenParameters& given, int branches, bool diffusion) {
  if (!given.start.empty()) {
    throw OptionError(fmt::format("--start {}: the joint method searches a grid and needs no start",
                                  given.start.begin()->first));
  }
  if (branches < 0 && given.NamesABranch()) {
    throw OptionError(
        "--fix and --bounds of a branch need --branches: without it the joint method chooses how "
        "many branches there are");
  }
  CheckGiven(given, FitParameterNames(diffusion, branches));
  for (const auto& [name, value] : given.fixed) {
    if (!name.starts_with("c_")) continue;
    throw OptionError(fmt::format(
        "--fix {}: the joint method knows branches by their time constants; fix tau_{} instead",
        name,
        name.substr(2)));
  }
  for (const auto& [name, ends] : given.bounds) {
    if (name == "beta" || name.starts_with("tau_")) continue;
    throw OptionError(fmt::format("--bounds {}: the joint method bounds beta and tau_j", name));
  }
}

// What a reference holds is not chosen beside it.
void RefuseBesideAReference(const Cell& held, const JointOptions& options, bool diffusion) {
  const auto refuse = [](bool given, std::string_view option) {
    if (given)
      throw OptionError(fmt::format(
          "option {}: --reference holds the terms of its cell; leave one of the two out", option));
  };
  refuse(options.branches >= 0, "--branches");
  refuse(options.resistance_nodes > 0, "--set joint.resistance_nodes");
  for (const auto& [presence, name] : {std::pair{options.self_heating, "self_heating"},
                                       std::pair{options.charge_transfer, "charge_transfer"},
                                       std::pair{options.temperature, "temperature"},
                                       std::pair{options.entropy, "entropy"},
                                       std::pair{options.hysteresis, "hysteresis"},
                                       std::pair{options.current_offset, "current_offset"}})
    refuse(presence != Presence::kAuto, fmt::format("--set joint.{}", name));
  refuse(!diffusion && held.diffusion, "--no-diffusion");
}

}  // namespace

void CheckJointRequest(const StagedGiven& given, const JointOptions& options, bool diffusion) {
  if (!given.reference) return CheckParameters(given.parameters, options.branches, diffusion);
  const Cell& held = given.reference->cell;
  RefuseBesideAReference(held, options, diffusion);
  CheckParameters(
      given.parameters, static_cast<int>(held.branches.size()), held.diffusion.has_value());
}

}  // namespace lipoid
