#include <array>

#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {

namespace {

struct SquareOptions {
  double side_m = 1.5;
  double altitude_m = 1.0;
  double corner_s = 5.0;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("side_m", self.side_m, Range{0.01, 1e4}, "length of a side, m");
    v("altitude_m", self.altitude_m, kManeuverHeights, "height to stay at, m");
    v("corner_s", self.corner_s, Range{0.1, 1e4}, "time from one corner to the next, s");
  }
};

FlightPlan Plan(const SquareOptions& options, std::optional<double> duration_s) {
  const double side_m = options.side_m;
  // Counter-clockwise seen from above, with x forward and y to the right.
  const std::array<std::array<double, 2>, 4> corners{
      {{0.0, 0.0}, {side_m, 0.0}, {side_m, -side_m}, {0.0, -side_m}}};
  FlightPlan plan{.commands = {}, .duration_s = duration_s.value_or(kUsualFlight_s)};
  std::size_t corner = 0;
  for (double time_s = 0.0; time_s < plan.duration_s; time_s += options.corner_s) {
    plan.commands.push_back({time_s,
                             {.altitude_m = options.altitude_m,
                              .x_m = corners[corner % 4][0],
                              .y_m = corners[corner % 4][1]}});
    const double left_s = time_s + options.corner_s;
    if (left_s <= plan.duration_s) plan.arrivals_s.push_back(left_s);
    ++corner;
  }
  return plan;
}

}  // namespace

Maneuver Square() {
  return ManeuverWith<SquareOptions, &Plan>(
      {.name = "square",
       .summary = "a square of 1.5 m at 1 m, counter-clockwise, a corner every 5 s",
       .source = "Fig 6.11; the thesis gives no times",
       .changes = true});
}

}  // namespace lipoid
