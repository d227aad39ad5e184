#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

FlightPlan HoverPlan(const ManeuverRequest&) {
  return {.commands = {{0.0, {.altitude_m = 1.1}}}, .duration_s = 50.0};
}

}  // namespace lipoid
