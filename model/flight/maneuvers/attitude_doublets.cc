#include <cmath>
#include <numbers>

#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

FlightPlan AttitudeDoubletsPlan(const ManeuverRequest&) {
  constexpr double kPitch_rad = 4.0 * std::numbers::pi / 180.0;
  constexpr double kDistance_m = 1.5;
  constexpr double kRest_s = 4.5;  // from the beginning of one way to that of the other
  FlightPlan plan{.commands = {{0.0, {.altitude_m = 1.1, .hold_position = false}}},
                  .duration_s = 50.0};
  // X'' = -g Theta: half of the way to gather speed, half to lose it.
  const double half_s = std::sqrt(kDistance_m / (kGravity_m_per_s2 * kPitch_rad));
  const auto pitch = [&](double time_s, double pitch_rad) {
    plan.commands.push_back(
        {time_s, {.altitude_m = 1.1, .hold_position = false, .pitch_rad = pitch_rad}});
  };
  double forward = -1.0;
  for (double time_s = 5.0; time_s + 2.0 * half_s < plan.duration_s; time_s += kRest_s) {
    pitch(time_s, forward * kPitch_rad);
    pitch(time_s + half_s, -forward * kPitch_rad);
    pitch(time_s + 2.0 * half_s, 0.0);
    forward = -forward;
  }
  return plan;
}

}  // namespace lipoid
