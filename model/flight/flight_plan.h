#pragma once

/// @file
/// What a maneuver is: commands that hold from their time until the next, and an end.

#include <algorithm>
#include <cstddef>
#include <vector>

#include "model/control/flight_controller.h"

namespace lipoid {

struct TimedCommand {
  double time_s;
  FlightCommand command;
};

struct FlightPlan {
  std::vector<TimedCommand>
      commands;  ///< in time, the first at 0: the flight starts hovering there
  double duration_s = 0.0;
  /// When the vehicle should be at the place of each command; none where nobody expects it there.
  std::vector<double> arrivals_s = {};

  /// All that is climbed until the end, m.
  [[nodiscard]] double Climb_m() const {
    double up_m = 0.0;
    for (std::size_t k = 1; k < commands.size() && commands[k].time_s < duration_s; ++k)
      up_m += std::max(0.0, commands[k].command.altitude_m - commands[k - 1].command.altitude_m);
    return up_m;
  }
  /// Times at which the commanded altitude changes.
  [[nodiscard]] std::vector<double> AltitudeSteps() const {
    std::vector<double> steps;
    for (std::size_t k = 1; k < commands.size(); ++k) {
      if (commands[k].command.altitude_m != commands[k - 1].command.altitude_m) {
        steps.push_back(commands[k].time_s);
      }
    }
    return steps;
  }
};

/// What a plan commands, asked in the order of time.
class PlanFollower {
 public:
  /// The plan outlives it.
  explicit PlanFollower(const FlightPlan& plan) : plan_(plan) {}

  /// A command holds from its time on, up to the rounding of k times the control step.
  [[nodiscard]] const FlightCommand& At(double time_s) {
    while (next_ < plan_.commands.size() && time_s >= plan_.commands[next_].time_s - 1e-9) ++next_;
    return plan_.commands[std::max<std::size_t>(next_, 1) - 1].command;
  }

 private:
  const FlightPlan& plan_;
  std::size_t next_ = 0;
};

}  // namespace lipoid
