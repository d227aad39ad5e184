#pragma once

/// @file
/// The only list of maneuvers: help, `list maneuvers` and messages are made from it. To add one: a
/// file here and a row in maneuvers.cc. Tests: tests/model/flight/maneuvers_test.cc.

#include <string>
#include <string_view>
#include <vector>

#include "model/flight/flight_plan.h"

namespace lipoid {

struct ManeuverRequest {
  std::string waypoints_file;  ///< for `waypoints`
};

struct Maneuver {
  std::string_view name;
  std::string_view summary;
  std::string_view source;  ///< where its times and heights are from
  FlightPlan (*plan)(const ManeuverRequest&);
  bool until_empty = false;  ///< meant to end with an empty battery
  bool needs_file = false;
};

[[nodiscard]] const std::vector<Maneuver>& Maneuvers();

/// Throws OptionError naming all maneuvers.
[[nodiscard]] const Maneuver& FindManeuver(std::string_view name);

FlightPlan HoverPlan(const ManeuverRequest&);
FlightPlan AltitudeStepsPlan(const ManeuverRequest&);
FlightPlan AttitudeDoubletsPlan(const ManeuverRequest&);
FlightPlan SquarePlan(const ManeuverRequest&);
FlightPlan EndurancePlan(const ManeuverRequest&);
/// LoadError for a file that is no list of waypoints.
FlightPlan WaypointsPlan(const ManeuverRequest&);

}  // namespace lipoid
