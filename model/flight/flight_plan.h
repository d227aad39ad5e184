#pragma once

/// @file
/// What a maneuver is: commands that hold from their time until the next, and an end.

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

}  // namespace lipoid
