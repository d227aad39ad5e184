#include <array>

#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

FlightPlan SquarePlan(const ManeuverRequest&) {
  constexpr double kSide_m = 1.5;
  constexpr double kCorner_s = 5.0;
  // Counter-clockwise seen from above, with x forward and y to the right.
  constexpr std::array<std::array<double, 2>, 4> kCorners{
      {{0.0, 0.0}, {kSide_m, 0.0}, {kSide_m, -kSide_m}, {0.0, -kSide_m}}};
  FlightPlan plan{.commands = {}, .duration_s = 50.0};
  std::size_t corner = 0;
  for (double time_s = 0.0; time_s < plan.duration_s; time_s += kCorner_s) {
    plan.commands.push_back(
        {time_s,
         {.altitude_m = 1.0, .x_m = kCorners[corner % 4][0], .y_m = kCorners[corner % 4][1]}});
    ++corner;
  }
  return plan;
}

}  // namespace lipoid
