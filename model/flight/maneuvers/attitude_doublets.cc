#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

namespace {

struct AttitudeDoubletsOptions {
  double altitude_m = 1.1;
  double pitch_deg = 4.0;
  double distance_m = 1.5;
  double every_s = 4.5;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("altitude_m", self.altitude_m, kManeuverHeights, "height to stay at, m");
    v("pitch_deg", self.pitch_deg, Range{0.1, 30.0}, "pitch angle, forward and back, degrees");
    v("distance_m", self.distance_m, Range{0.01, 1e3}, "distance to fly before turning back, m");
    v("every_s",
      self.every_s,
      Range{0.1, 1e4},
      "time from the beginning of one way to that of the next, s; at least as long as a way takes");
  }
};

FlightPlan Plan(const AttitudeDoubletsOptions& options, std::optional<double> duration_s) {
  const double pitch_angle_rad = options.pitch_deg * std::numbers::pi / 180.0;
  const auto level = [&](double pitch_rad) {
    return FlightCommand{
        .altitude_m = options.altitude_m, .hold_position = false, .pitch_rad = pitch_rad};
  };
  FlightPlan plan{.commands = {{0.0, level(0.0)}},
                  .duration_s = duration_s.value_or(kUsualFlight_s)};
  // X'' = -g Theta: half of the way to gather speed, half to lose it.
  const double half_s = std::sqrt(options.distance_m / (kGravity_m_per_s2 * pitch_angle_rad));
  const double every_s = std::max(options.every_s, 2.0 * half_s + kControlStep_s);
  double forward = -1.0;
  for (double time_s = 5.0; time_s + 2.0 * half_s < plan.duration_s; time_s += every_s) {
    plan.commands.push_back({time_s, level(forward * pitch_angle_rad)});
    plan.commands.push_back({time_s + half_s, level(-forward * pitch_angle_rad)});
    plan.commands.push_back({time_s + 2.0 * half_s, level(0.0)});
    forward = -forward;
  }
  return plan;
}

}  // namespace

Maneuver AttitudeDoublets() {
  return ManeuverWith<AttitudeDoubletsOptions, &Plan>(
      {.name = "attitude-doublets",
       .summary =
           "pitch by 4 degrees forward and back, 1.5 m each way, a way every 4.5 s until the flight "
           "ends",
       .source = "Fig 6.9, read off the picture",
       .changes = true});
}

}  // namespace lipoid
