#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {
namespace {

struct AltitudeStepsOptions {
  double low_m = 1.1;
  double high_m = 1.5;
  double first_s = 12.5;
  double every_s = 7.5;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("low_m", self.low_m, kManeuverHeights, "height at the start and after every second step, m");
    v("high_m", self.high_m, kManeuverHeights, "height after the first step, m");
    v("first_s", self.first_s, Range{kControlStep_s, 1e4}, "time of the first step, s");
    v("every_s", self.every_s, Range{0.1, 1e4}, "time between steps, s");
  }
};

FlightPlan Plan(const AltitudeStepsOptions& options, std::optional<double> duration_s) {
  FlightPlan plan{.commands = {{0.0, {.altitude_m = options.low_m}}},
                  .duration_s = duration_s.value_or(kUsualFlight_s)};
  bool high = false;
  for (double time_s = options.first_s; time_s < plan.duration_s; time_s += options.every_s) {
    high = !high;
    plan.commands.push_back({time_s, {.altitude_m = high ? options.high_m : options.low_m}});
  }
  return plan;
}

}  // namespace

Maneuver AltitudeSteps() {
  return ManeuverWith<AltitudeStepsOptions, &Plan>(
      {.name = "altitude-steps",
       .summary = "up and down between 1.1 m and 1.5 m, a step every 7.5 s until the flight ends",
       .source = "Fig 6.7, read off the picture",
       .changes = true});
}

}  // namespace lipoid
