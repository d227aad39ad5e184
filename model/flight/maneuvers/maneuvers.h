#pragma once

/// @file
/// The only list of maneuvers: help, `list maneuvers`, `--set square.side_m=2` and messages are made
/// from it. To add one: a file here, which CMake finds, and its name in maneuvers.cc. Tests:
/// tests/model/flight/maneuvers_test.cc.

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "model/core/options.h"
#include "model/flight/flight_plan.h"

namespace lipoid {

struct ManeuverRequest {
  std::string waypoints_file = {};                 ///< for `waypoints`
  std::map<std::string, std::string> values = {};  ///< options of the maneuver, as text
  std::optional<double> duration_s = {};           ///< of the flight; none: that of the maneuver
};

struct Maneuver {
  std::string_view name;
  std::string_view summary;
  std::string_view source;  ///< where its times and heights are from
  /// OptionError for a value that the maneuver does not take, LoadError for a file that is no list
  /// of waypoints.
  FlightPlan (*plan)(const ManeuverRequest&) = nullptr;
  std::vector<OptionDescription> (*options)() = nullptr;
  /// Every option with the value that it has in the request.
  std::vector<std::pair<std::string, std::string>> (*values)(const ManeuverRequest&) = nullptr;
  bool until_empty = false;  ///< meant to end with an empty battery
  bool needs_file = false;
  bool changes = false;  ///< asks for more than its start
};

/// A maneuver whose options are the struct `Options` (model/core/options.h).
template <class Options>
[[nodiscard]] Options OptionsOf(const ManeuverRequest& request) {
  Options options;
  for (const auto& [name, text] : request.values) SetOption(options, name, text);
  return options;
}
template <class Options, FlightPlan (*kPlan)(const Options&, std::optional<double> duration_s)>
[[nodiscard]] Maneuver ManeuverWith(Maneuver row) {
  row.plan = [](const ManeuverRequest& request) {
    return kPlan(OptionsOf<Options>(request), request.duration_s);
  };
  row.options = &DescribeOptions<Options>;
  row.values = [](const ManeuverRequest& request) {
    return OptionValues(OptionsOf<Options>(request));
  };
  return row;
}

[[nodiscard]] const std::vector<Maneuver>& Maneuvers();

/// Throws OptionError naming all maneuvers.
[[nodiscard]] const Maneuver& FindManeuver(std::string_view name);

/// As long as the pictures of the thesis.
inline constexpr double kUsualFlight_s = 50.0;

/// Heights that a maneuver may be flown at, m.
inline constexpr Range kManeuverHeights{0.1, 1e4};

Maneuver Hover();
Maneuver AltitudeSteps();
Maneuver AttitudeDoublets();
Maneuver Square();
Maneuver Endurance();
Maneuver Waypoints();

}  // namespace lipoid
