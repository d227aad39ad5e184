#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

FlightPlan EndurancePlan(const ManeuverRequest&) {
  // Eleven days: no cell that carries a quadrotor lasts as long.
  return {.commands = {{0.0, {.altitude_m = 1.1}}}, .duration_s = 1e6};
}

}  // namespace lipoid
