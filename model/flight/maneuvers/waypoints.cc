#include <algorithm>
#include <numbers>

#include "model/core/errors.h"
#include "model/core/json.h"
#include "model/core/toml_reader.h"
#include "model/flight/maneuvers/maneuvers.h"

namespace lipoid {
namespace {

constexpr double kFar_m = 1e4;
constexpr double kLong_s = 1e5;

// One [[waypoint]]: a place, and how long to stay before the next.
struct Waypoint {
  FlightCommand command;
  double stay_s = 5.0;
};

Waypoint ReadWaypoint(const TomlReader& table) {
  Waypoint point;
  double yaw_deg = 0.0;
  table.OnlyKeys({"x_m", "y_m", "altitude_m", "yaw_deg", "stay_s"});
  if (table.Find("altitude_m") == nullptr)
    table.Problem(table.At(), "altitude_m: expected, found none");
  table.Number("x_m", -kFar_m, kFar_m, "a distance within 10 km", point.command.x_m);
  table.Number("y_m", -kFar_m, kFar_m, "a distance within 10 km", point.command.y_m);
  table.Number("altitude_m", 0.1, kFar_m, "a height from 0.1 m to 10 km", point.command.altitude_m);
  table.Number("yaw_deg", -3600.0, 3600.0, "a heading in degrees", yaw_deg);
  table.Number("stay_s", kControlStep_s, kLong_s, "a time from 0.005 s to 1e5 s", point.stay_s);
  point.command.yaw_rad = yaw_deg * std::numbers::pi / 180.0;
  return point;
}

FlightPlan Plan(const ManeuverRequest& request) {
  const std::string& file = request.waypoints_file;
  const toml::table document =
      ParseToml(ReadTextFile(file),
                file,
                "a list of waypoints, tables [[waypoint]] with altitude_m, x_m, y_m, stay_s,");
  std::vector<Diagnostic> problems;
  const TomlReader top(document, file, problems);
  top.OnlyKeys({"waypoint"});
  const toml::node* node = top.Find("waypoint");
  const toml::array* list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr || list->empty() || !list->is_homogeneous(toml::node_type::table)) {
    throw LoadError({file}, "expected tables [[waypoint]] with altitude_m, x_m, y_m, stay_s");
  }
  FlightPlan plan;
  for (const toml::node& item : *list) {
    const Waypoint point = ReadWaypoint(TomlReader(*item.as_table(), file, problems));
    plan.commands.push_back({plan.duration_s, point.command});
    plan.duration_s += point.stay_s;
    plan.arrivals_s.push_back(plan.duration_s);
  }
  ThrowProblems(std::move(problems));
  return plan;
}

}  // namespace

Maneuver Waypoints() {
  return {.name = "waypoints",
          .summary = "from place to place as a file says",
          .source = "the user's file",
          .plan = &Plan,
          .needs_file = true};
}

}  // namespace lipoid
