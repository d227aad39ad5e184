#include "model/flight/maneuvers/maneuvers.h"

#include "model/core/nearest_name.h"

namespace lipoid {

const std::vector<Maneuver>& Maneuvers() {
  static const std::vector<Maneuver> all{
      Hover(), AltitudeSteps(), AttitudeDoublets(), Square(), Endurance(), Waypoints()};
  return all;
}

const Maneuver& FindManeuver(std::string_view name) {
  return FindNamed("maneuver", name, Maneuvers());
}

}  // namespace lipoid
