#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

FlightPlan AltitudeStepsPlan(const ManeuverRequest&) {
  FlightPlan plan{.commands = {{0.0, {.altitude_m = 1.1}}}, .duration_s = 50.0};
  double altitude_m = 1.1;
  for (double time_s = 12.5; time_s < plan.duration_s; time_s += 7.5) {
    altitude_m = altitude_m == 1.1 ? 1.5 : 1.1;
    plan.commands.push_back({time_s, {.altitude_m = altitude_m}});
  }
  return plan;
}

}  // namespace lipoid
