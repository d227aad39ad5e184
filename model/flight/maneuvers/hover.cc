#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {
namespace {

struct HoverOptions {
  double altitude_m = 1.1;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("altitude_m", self.altitude_m, kManeuverHeights, "height to stay at, m");
  }
};

FlightPlan Plan(const HoverOptions& options, std::optional<double> duration_s) {
  return {.commands = {{0.0, {.altitude_m = options.altitude_m}}},
          .duration_s = duration_s.value_or(kUsualFlight_s)};
}

// Eleven days: no cell that carries a quadrotor lasts as long.
FlightPlan LongPlan(const HoverOptions& options, std::optional<double> duration_s) {
  return Plan(options, duration_s.value_or(1e6));
}

}  // namespace

Maneuver Hover() {
  return ManeuverWith<HoverOptions, &Plan>({.name = "hover",
                                            .summary = "stay at 1.1 m until the flight ends",
                                            .source = "section 6.1.5's height"});
}

Maneuver Endurance() {
  return ManeuverWith<HoverOptions, &LongPlan>(
      {.name = "endurance",
       .summary = "hover at 1.1 m until the battery is empty",
       .source = "ours",
       .until_empty = true});
}

}  // namespace lipoid
