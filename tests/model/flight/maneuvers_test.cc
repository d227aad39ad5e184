#include "model/flight/maneuvers/maneuvers.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "model/core/errors.h"
#include "tests/support/text_files.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

TEST(Maneuvers, HaveNamesOfTheirOwnAndPlansInOrder) {
  std::set<std::string_view> names;
  for (const Maneuver& maneuver : Maneuvers()) {
    EXPECT_TRUE(names.insert(maneuver.name).second) << maneuver.name;
    EXPECT_FALSE(maneuver.summary.empty());
    if (maneuver.needs_file) continue;
    const FlightPlan plan = maneuver.plan({});
    ASSERT_FALSE(plan.commands.empty()) << maneuver.name;
    EXPECT_EQ(plan.commands.front().time_s, 0.0) << maneuver.name;
    for (std::size_t k = 1; k < plan.commands.size(); ++k) {
      EXPECT_GT(plan.commands[k].time_s, plan.commands[k - 1].time_s) << maneuver.name;
    }
    EXPECT_LT(plan.commands.back().time_s, plan.duration_s) << maneuver.name;
  }
  for (const char* name :
       {"hover", "altitude-steps", "attitude-doublets", "square", "endurance", "waypoints"}) {
    EXPECT_EQ(names.count(name), 1U) << name;
  }
}

TEST(Maneuvers, AltitudeStepsAreThoseOfTheCorrections) {
  const FlightPlan plan = AltitudeSteps().plan({});
  EXPECT_EQ(plan.duration_s, 50.0);
  EXPECT_EQ(plan.AltitudeSteps(), (std::vector<double>{12.5, 20.0, 27.5, 35.0, 42.5}));
  double up = 1.0;
  for (std::size_t k = 1; k < plan.commands.size(); ++k, up = -up) {
    EXPECT_NEAR(plan.commands[k].command.altitude_m - plan.commands[k - 1].command.altitude_m,
                0.4 * up,
                1e-15);
  }
}

TEST(Maneuvers, DoubletsComeBackToWhereTheyBegan) {
  // X'' = -g Theta, integrated exactly over the pieces of constant pitch.
  const FlightPlan plan = AttitudeDoublets().plan({});
  double x = 0.0;
  double speed = 0.0;
  double farthest = 0.0;
  for (std::size_t k = 0; k < plan.commands.size(); ++k) {
    const double end = k + 1 < plan.commands.size() ? plan.commands[k + 1].time_s : plan.duration_s;
    const double dt = end - plan.commands[k].time_s;
    const double pull = -kGravity_m_per_s2 * plan.commands[k].command.pitch_rad;
    EXPECT_LE(std::abs(plan.commands[k].command.pitch_rad), 4.0 * M_PI / 180.0 + 1e-15);
    x += speed * dt + 0.5 * pull * dt * dt;
    speed += pull * dt;
    farthest = std::max(farthest, x);
  }
  EXPECT_NEAR(farthest, 1.5, 1e-12);
  EXPECT_NEAR(x, 0.0, 1e-12);
  EXPECT_NEAR(speed, 0.0, 1e-12);
}

TEST(Maneuvers, TheSquareRunsCounterClockwise) {
  // Seen from above with x ahead and y to the right, the shoelace sum of such a tour is negative.
  const FlightPlan plan = Square().plan({});
  double twice_area = 0.0;
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& a = plan.commands[k].command;
    const auto& b = plan.commands[k + 1].command;
    twice_area += a.x_m * b.y_m - b.x_m * a.y_m;
    EXPECT_NEAR(std::hypot(b.x_m - a.x_m, b.y_m - a.y_m), 1.5, 1e-15);
  }
  EXPECT_NEAR(twice_area, -2.0 * 1.5 * 1.5, 1e-15);
}

TEST(Maneuvers, TakeOptionsOfTheirOwnAndKeepTheThesisWithout) {
  const Maneuver& square = FindManeuver("square");
  ManeuverRequest request;
  request.values = {{"side_m", "4"}, {"corner_s", "10"}};
  const FlightPlan wide = square.plan(request);
  ASSERT_EQ(wide.commands.size(), 5U);  // 50 s
  EXPECT_EQ(wide.commands[1].time_s, 10.0);
  EXPECT_EQ(wide.commands[1].command.x_m, 4.0);
  EXPECT_EQ(wide.commands[1].command.altitude_m, 1.0);
  EXPECT_EQ(square.values(request),
            (std::vector<std::pair<std::string, std::string>>{
                {"side_m", "4"}, {"altitude_m", "1"}, {"corner_s", "10"}}));
  request.values = {{"low_m", "2"}, {"high_m", "3"}, {"first_s", "1"}, {"every_s", "20"}};
  const FlightPlan steps = FindManeuver("altitude-steps").plan(request);
  ASSERT_EQ(steps.commands.size(), 4U);
  EXPECT_EQ(steps.commands[0].command.altitude_m, 2.0);
  EXPECT_EQ(steps.commands[1].command.altitude_m, 3.0);
  EXPECT_EQ(steps.commands[3].time_s, 41.0);

  // Twice as far at half the angle takes twice as long; ways do not overlap.
  request.values = {{"pitch_deg", "2"}, {"distance_m", "3"}, {"every_s", "0.1"}};
  const FlightPlan ways = FindManeuver("attitude-doublets").plan(request);
  const FlightPlan usual = FindManeuver("attitude-doublets").plan({});
  EXPECT_NEAR(ways.commands[2].time_s - ways.commands[1].time_s,
              2.0 * (usual.commands[2].time_s - usual.commands[1].time_s),
              1e-12);
  for (std::size_t k = 1; k < ways.commands.size(); ++k)
    EXPECT_GT(ways.commands[k].time_s, ways.commands[k - 1].time_s);

  request.values = {{"side_m", "-1"}};
  EXPECT_NE(test::MessageOf<OptionError>([&] { (void)square.plan(request); }).find("side_m"),
            std::string::npos);
  request.values = {{"radius_m", "1"}};
  EXPECT_NE(test::MessageOf<OptionError>([&] { (void)square.plan(request); }).find("radius_m"),
            std::string::npos);
}

// As long as the flight, not as long as the pictures.
TEST(Maneuvers, GoOnForTheWholeFlight) {
  for (const char* name : {"altitude-steps", "attitude-doublets", "square"}) {
    const Maneuver& maneuver = FindManeuver(name);
    const FlightPlan usual = maneuver.plan({});
    const FlightPlan longer = maneuver.plan({.duration_s = 200.0});
    EXPECT_EQ(longer.duration_s, 200.0);
    EXPECT_GT(longer.commands.size(), 3 * usual.commands.size()) << name;
    for (std::size_t k = 0; k < usual.commands.size(); ++k)
      EXPECT_EQ(longer.commands[k].time_s, usual.commands[k].time_s) << name;
    EXPECT_TRUE(maneuver.changes) << name;
    EXPECT_EQ(maneuver.plan({.duration_s = 1.0}).commands.size(), 1U) << name;
  }
}

TEST(Maneuvers, UnknownNamesAreAnswered) {
  EXPECT_EQ(test::MessageOf<OptionError>([] { (void)FindManeuver("loop"); }),
            "unknown maneuver 'loop'. Known: hover, altitude-steps, attitude-doublets, square, "
            "endurance, waypoints");
}

TEST(Waypoints, AreFlownOneAfterTheOther) {
  const std::string file = test::WriteText("way.toml", R"(
[[waypoint]]
altitude_m = 1.0
[[waypoint]]
x_m = 2.0
y_m = -1.0
altitude_m = 1.5
yaw_deg = 90
stay_s = 7.5
)");
  const FlightPlan plan = Waypoints().plan({.waypoints_file = file, .values = {}});
  ASSERT_EQ(plan.commands.size(), 2U);
  EXPECT_EQ(plan.commands[1].time_s, 5.0);
  EXPECT_EQ(plan.duration_s, 12.5);
  EXPECT_EQ(plan.arrivals_s, (std::vector<double>{5.0, 12.5}));
  EXPECT_EQ(plan.commands[1].command.y_m, -1.0);
  EXPECT_NEAR(plan.commands[1].command.yaw_rad, 0.5 * M_PI, 1e-15);
}

TEST(Waypoints, EveryMistakeIsNamed) {
  const std::string file = test::WriteText("bad.toml", R"([[waypoint]]
x_m = 2.0
height = 3
[[waypoint]]
altitude_m = -1
stay_s = "long"
)");
  const std::string message = test::MessageOf<LoadError>(
      [&] { (void)Waypoints().plan({.waypoints_file = file, .values = {}}); });
  for (const char* part :
       {":3:1: error: expected one of the keys",
        "found 'height'",
        "altitude_m: expected, found none",
        ":5:14: error: altitude_m: expected a height from 0.1 m to 10 km, found -1",
        ":6:10: error: stay_s: expected a time from 0.005 s to 1e5 s"}) {
    EXPECT_NE(message.find(part), std::string::npos) << part << "\n" << message;
  }
  const std::string empty = test::WriteText("empty.toml", "waypoint = 3\n");
  EXPECT_NE(test::MessageOf<LoadError>([&] {
              (void)Waypoints().plan({.waypoints_file = empty, .values = {}});
            }).find("expected tables [[waypoint]]"),
            std::string::npos);
}

}  // namespace
}  // namespace lipoid
