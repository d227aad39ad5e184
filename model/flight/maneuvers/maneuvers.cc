#include "model/flight/maneuvers/maneuvers.h"

#include <fmt/format.h>

#include "model/core/errors.h"
#include "model/core/nearest_name.h"

namespace lipoid {

const std::vector<Maneuver>& Maneuvers() {
  static const std::vector<Maneuver> all{
      Hover(), AltitudeSteps(), AttitudeDoublets(), Square(), Endurance(), Waypoints()};
  return all;
}

FlightPlan WithCommands(FlightPlan plan, std::string_view maneuver) {
  if (plan.commands.size() > 1) return plan;
  throw OptionError(fmt::format(
      "{}: nothing is asked for within {:g} s; give a longer --duration, or earlier times (--set {}.*)",
      maneuver,
      plan.duration_s,
      maneuver));
}

const Maneuver& FindManeuver(std::string_view name) {
  std::vector<std::string> known;
  for (const Maneuver& maneuver : Maneuvers()) {
    if (maneuver.name == name) return maneuver;
    known.emplace_back(maneuver.name);
  }
  throw OptionError(UnknownName("maneuver", name, known));
}

}  // namespace lipoid
