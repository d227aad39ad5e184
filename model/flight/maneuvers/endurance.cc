#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

FlightPlan EndurancePlan(const ManeuverRequest&) {
  // Two hours: an ideal source never ends.
  return {.commands = {{0.0, {.altitude_m = 1.1}}}, .duration_s = 7200.0};
}

}  // namespace lipoid
