#include "model/flight/maneuvers/maneuvers.h"

#include "model/core/errors.h"
#include "model/core/nearest_name.h"

namespace lipoid {

const std::vector<Maneuver>& Maneuvers() {
  static const std::vector<Maneuver> all{
      Hover(), AltitudeSteps(), AttitudeDoublets(), Square(), Endurance(), Waypoints()};
  return all;
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
