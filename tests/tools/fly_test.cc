// lipoid fly, poles, design, end to end. What they find: tests/model/flight/,
// tests/model/analysis/, tests/identify/gains/.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "model/battery/cell_file.h"
#include "model/core/atomic_file.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

// Of a message; the second says how to get help.
std::string FirstLineWithBreak(const std::string& text) {
  return text.substr(0, text.find('\n') + 1);
}

TEST(Fly, WritesTheLogAndTheSummary) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"fly",
                              "altitude-steps",
                              "--cell",
                              "gifi-600mAh-1",
                              "--vehicle",
                              "mambo-coupled",
                              "-o",
                              "flight.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("outcome"), "completed");
  EXPECT_EQ(summary.at("steps"), 10000);
  EXPECT_EQ(summary.at("simulated_s"), 50.0);
  EXPECT_EQ(summary.at("peak_altitude_error_m").size(), 5U);
  for (const char* key : {"wall_s",
                          "mse_altitude_m2",
                          "mse_pitch_deg2",
                          "charge_C",
                          "final_voltage_V",
                          "final_soc",
                          "minimum_voltage_V"}) {
    EXPECT_TRUE(summary.at(key).is_number()) << key;
  }
  const std::string csv = ReadTextFile(folder + "/flight.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 10001);
  EXPECT_EQ(csv.substr(0, csv.find(',')), "time_s");
  EXPECT_NE(csv.find(",battery_V,battery_A,soc\n"), std::string::npos);
  EXPECT_NE(run.out.find("completed"), std::string::npos);
}

TEST(Fly, SaysWhatTheVehicleLooksLike) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"fly", "hover", "--duration", "1", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  const auto& motors = summary.at("vehicle_geometry").at("motors");
  ASSERT_EQ(motors.size(), 4U);
  // Front right, back right, back left, front left; the thesis' front right turns clockwise.
  const double lever_m = 0.062 * std::sqrt(0.5);
  const auto expect_motor = [&](std::size_t k, double ahead, double right, const char* turns) {
    EXPECT_DOUBLE_EQ(motors[k].at("ahead_m").get<double>(), ahead * lever_m) << k;
    EXPECT_DOUBLE_EQ(motors[k].at("right_m").get<double>(), right * lever_m) << k;
    EXPECT_EQ(motors[k].at("turns"), turns) << k;
  };
  expect_motor(0, 1.0, 1.0, "clockwise");
  expect_motor(1, -1.0, 1.0, "counter-clockwise");
  expect_motor(2, -1.0, -1.0, "clockwise");
  expect_motor(3, 1.0, -1.0, "counter-clockwise");
  EXPECT_EQ(summary.at("cutoff_V"), 3.0);
}

TEST(Fly, NeedsNothingButAManeuver) {
  const auto run = RunLipoid(TestFolder(), {"fly", "hover", "--duration", "1"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("mambo-coupled on"), std::string::npos) << run.err;
}

TEST(Fly, SaysWhichSettingsChangeNothing) {
  const auto folder = TestFolder();
  const auto both = RunLipoid(
      folder,
      {"fly", "hover", "--duration", "1", "--controller", "lqr", "--set", "controller.law=pid"});
  EXPECT_EQ(both.exit_code, 2);
  EXPECT_NE(both.err.find("--controller and --set controller.law: give one"), std::string::npos);
  const std::vector<std::string> noisy{
      "fly", "hover", "--duration", "1", "--set", "sensors.flow_noise_m_per_s=9"};
  EXPECT_NE(RunLipoid(folder, noisy).err.find("change nothing without --estimate"),
            std::string::npos);
  auto estimated = noisy;
  estimated.push_back("--estimate");
  EXPECT_EQ(RunLipoid(folder, estimated).err.find("change nothing"), std::string::npos);
  const auto hover = RunLipoid(folder,
                               {"endurance",
                                "--cell",
                                "gifi-600mAh-1",
                                "--vehicle",
                                "mambo-physical",
                                "--set",
                                "air.induced_power_factor=2"});
  EXPECT_NE(hover.err.find("change nothing in a hover"), std::string::npos) << hover.err;
}

TEST(Fly, ARowOfTheLogIsAWholeNumberOfControlSteps) {
  const auto folder = TestFolder();
  const auto run = [&](const char* step_s) {
    return RunLipoid(folder,
                     {"fly", "hover", "--duration", "1", "--log-step-s", step_s, "-o", "f.csv"});
  };
  const auto odd = run("0.007");
  EXPECT_EQ(odd.exit_code, 2);
  EXPECT_EQ(
      FirstLineWithBreak(odd.err),
      "lipoid fly: error: option --log-step-s: expected a multiple of the control step of 0.005 "
      "s, found 0.007 s; give 0.005 or 0.01\n");
  for (const char* step_s : {"0.005", "0.015", "0.1", "0.35"})
    EXPECT_EQ(run(step_s).exit_code, 0) << step_s;
}

TEST(Fly, CrashesAndEmptyBatteriesAreExitCodeOne) {
  const auto folder = TestFolder();
  auto run = RunLipoid(folder, {"fly", "hover", "--xi", "0.6", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(ReadJson(folder, "s.json").at("outcome"), "crashed");
  EXPECT_NE(
      run.err.find("mambo-thesis cannot hover on this battery: it would need a duty cycle of"),
      std::string::npos)
      << run.err;
  run = RunLipoid(folder, {"fly", "endurance", "--initial-soc", "0.2", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_EQ(ReadJson(folder, "s.json").at("outcome"), "battery-empty");
}

// Flights alone show v_oc only as far as they were flown.
TEST(Fly, SaysWhereNoLogHasShownTheVoltage) {
  const auto folder = TestFolder();
  WriteFlownCell(folder, {0.9, 1.0}, {4.1, 4.15});
  const auto said = [&](const std::string& duration_s) {
    const auto run = RunLipoid(
        folder,
        {"fly", "hover", "--cell", "flown.json", "--duration", duration_s, "--summary", "s.json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const bool doubted =
        run.err.find("v_oc of flown is known between 0.9 and 1 of the charge") != std::string::npos;
    EXPECT_EQ(ReadJson(folder, "s.json").at("doubts").size(), doubted ? 1U : 0U);
    return doubted;
  };
  EXPECT_FALSE(said("5"));
  EXPECT_TRUE(said("120"));
}

TEST(Fly, WhatIsBlownAwayIsSaidFirst) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(
      folder, {"fly", "hover", "--wind", "30", "--duration", "30", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.out.starts_with("Off course: it could not hold its place: from 0.")) << run.out;
  EXPECT_NE(run.out.find("position error"), std::string::npos) << run.out;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("outcome"), "off-course");
  EXPECT_GT(summary.at("largest_position_error_m"), 100.0);
  EXPECT_GT(summary.at("mse_position_m2"), 1e4);
  // An empty battery is the outcome, and that it was blown away is said too.
  const auto empty =
      RunLipoid(folder, {"fly", "endurance", "--wind", "30", "--initial-soc", "0.5"});
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_NE(empty.err.find("; it could not hold its place: from "), std::string::npos) << empty.err;
}

TEST(Fly, SaysThatASpeedWasNotReached) {
  const auto folder = TestFolder();
  WriteText(folder + "/line.toml",
            "[[waypoint]]\naltitude_m = 10\nstay_s = 1\n"
            "[[waypoint]]\naltitude_m = 10\nx_m = 60\nstay_s = 45\n");
  const auto fly = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"fly",
                                   "waypoints",
                                   "--waypoints",
                                   "line.toml",
                                   "--vehicle",
                                   "f450",
                                   "--xi",
                                   "1",
                                   "--summary",
                                   "s.json"};
    words.insert(words.end(), more.begin(), more.end());
    return RunLipoid(folder, words).err;
  };
  const std::string as_usual = fly({});
  EXPECT_EQ(as_usual.find("the vehicle flew at most"), std::string::npos) << as_usual;
  EXPECT_NEAR(ReadJson(folder, "s.json").at("fastest_m_per_s").get<double>(), 3.0, 0.2);
  const std::string far = fly({"--set", "controller.position_speed_m_per_s=20"});
  EXPECT_NE(
      far.find("of the 20 m/s that position_speed_m_per_s allows: no way between waypoints is "
               "long enough"),
      std::string::npos)
      << far;
  // m g tan 20 degrees holds 0.56 m/s against this drag.
  std::string vehicle = ReadTextFile(SourcePath("fixtures/vehicles/mambo-physical.toml"));
  const std::string drag = "linear_drag_N_s_per_m = 0.02";
  vehicle.replace(vehicle.find(drag), drag.size(), "linear_drag_N_s_per_m = 0.4");
  WriteText(folder + "/kite.toml", vehicle);
  const auto weak = RunLipoid(folder,
                              {"fly",
                               "waypoints",
                               "--waypoints",
                               "line.toml",
                               "--vehicle",
                               "kite.toml",
                               "--xi",
                               "1",
                               "--set",
                               "simulation.drag=true"});
  EXPECT_NE(
      weak.err.find("along x or y, where its references had 1.5 m/s: a tilt of 20.1 degrees holds"),
      std::string::npos)
      << weak.err;
}

TEST(Fly, WindWithoutDragIsRefused) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(
      folder, {"fly", "hover", "--duration", "1", "--wind", "3", "--set", "simulation.drag=false"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(
      run.err.find("option --set simulation.drag=false: wind and gusts act on the vehicle by its "
                   "drag alone"),
      std::string::npos)
      << run.err;
}

TEST(Fly, WaypointsThatWereMissedAreSaidFirst) {
  const auto folder = TestFolder();
  WriteText(folder + "/far.toml",
            "[[waypoint]]\naltitude_m = 1\n"
            "[[waypoint]]\naltitude_m = 60\nx_m = 200\nstay_s = 5\n");
  const auto run =
      RunLipoid(folder, {"fly", "waypoints", "--waypoints", "far.toml", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.out.starts_with("Off course: it missed 1 of 2 waypoints: 19")) << run.out;
  EXPECT_NE(run.out.find("m away at the end of its stay"), std::string::npos) << run.out;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("outcome"), "off-course");
  ASSERT_EQ(summary.at("waypoint_distance_m").size(), 2U);
  EXPECT_LT(summary.at("waypoint_distance_m")[0], 0.1);
  EXPECT_GT(summary.at("waypoint_distance_m")[1], 150.0);
}

// A turn takes its time; and nobody pays for the height.
TEST(Fly, SaysThatItHadNotTurnedAndWhatAClimbLeavesOut) {
  const auto folder = TestFolder();
  const auto fly = [&](double yaw_deg, double stay_s) {
    std::ofstream(folder + "/turn.toml")
        << "[[waypoint]]\naltitude_m = 1\n[[waypoint]]\naltitude_m = 1\nyaw_deg = " << yaw_deg
        << "\nstay_s = " << stay_s << '\n';
    return RunLipoid(folder,
                     {"fly", "waypoints", "--waypoints", "turn.toml", "--summary", "s.json"});
  };
  const auto hasty = fly(170.0, 0.1);
  EXPECT_EQ(hasty.exit_code, 1);
  EXPECT_TRUE(hasty.out.starts_with("Off course: it had not turned: 1")) << hasty.out;
  EXPECT_NE(hasty.out.find("degrees from its heading then"), std::string::npos) << hasty.out;
  const auto errors_rad = ReadJson(folder, "s.json").at("waypoint_heading_error_rad");
  ASSERT_EQ(errors_rad.size(), 2U);
  EXPECT_LT(errors_rad[0], 1e-3);
  EXPECT_GT(errors_rad[1], 2.0);
  const auto turned = fly(170.0, 30.0);
  EXPECT_EQ(turned.exit_code, 0) << turned.out;
  EXPECT_LT(ReadJson(folder, "s.json").at("waypoint_heading_error_rad")[1], 0.02);
  EXPECT_EQ(turned.err.find("climb"), std::string::npos) << turned.err;

  WriteText(folder + "/up.toml",
            "[[waypoint]]\naltitude_m = 1\n[[waypoint]]\naltitude_m = 21\nstay_s = 30\n"
            "[[waypoint]]\naltitude_m = 1\nstay_s = 30\n");
  const auto up = RunLipoid(folder, {"fly", "waypoints", "--waypoints", "up.toml"});
  const double energy_Wh = 0.063 * 9.81 * 20.0 / 3600.0;  // of a Mambo of 63 g
  const auto said = fmt::format("the 20 m up of this flight take {:.2g}", energy_Wh);
  EXPECT_NE(up.err.find(said), std::string::npos) << said << '\n' << up.err;
}

TEST(Fly, AFlightThatEndsBeforeItsWaypointsSaysSo) {
  const auto folder = TestFolder();
  WriteText(folder + "/near.toml",
            "[[waypoint]]\naltitude_m = 1\n"
            "[[waypoint]]\naltitude_m = 1\nx_m = 1\nstay_s = 5\n");
  const auto run = RunLipoid(
      folder,
      {"fly", "waypoints", "--waypoints", "near.toml", "--duration", "3", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("before the stays at"), std::string::npos) << run.err;
  EXPECT_FALSE(ReadJson(folder, "s.json").at("doubts").empty());
}

TEST(Fly, AVehicleThatTheWindCarriesOffSaysHowFar) {
  const auto folder = TestFolder();
  const auto said = [&](const char* wind) {
    const auto run = RunLipoid(folder,
                               {"fly",
                                "hover",
                                "--vehicle",
                                "f450",
                                "--wind",
                                wind,
                                "--battery",
                                "ideal",
                                "--duration",
                                "20"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err.find("m from its place: the position loop has no integral") != std::string::npos;
  };
  EXPECT_FALSE(said("0.5"));
  EXPECT_TRUE(said("9"));
}

TEST(Fly, CornersThatAreNotReachedAreMissed) {
  const auto folder = TestFolder();
  const auto run =
      RunLipoid(folder, {"fly", "square", "--set", "square.side_m=100", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.out.starts_with("Off course: it missed 9 of 10 waypoints")) << run.out;
  EXPECT_NE(run.out.find("largest of 10 distances"), std::string::npos) << run.out;
}

TEST(Fly, ACurrentThatTheBatteryCannotGiveIsNone) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(
      folder,
      {"fly", "hover", "--vehicle", "f450", "--cell", "gifi-600mAh-1", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(run.err.find("it never gives the power"), std::string::npos) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("trim").at("battery_A"), nullptr);
}

TEST(Fly, EnduranceEndsOnlyWithTheBattery) {
  // 33 Ah at 3 A are eleven hours.
  const auto folder = TestFolder();
  const auto run =
      RunLipoid(folder, {"fly", "endurance", "--cell", "grepow-32Ah-1", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("outcome"), "battery-empty");
  EXPECT_GT(ReadJson(folder, "s.json").at("simulated_s"), 30000.0);
}

// cell.json with an uncertain r_s and beta.
std::string FolderWithUncertainCell() {
  auto folder = TestFolder();
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.uncertainty = Cell::Uncertainty{.parameters = {"r_s", "beta"},
                                       .covariance = {{4e-4, 0.0}, {0.0, 1e-4}},
                                       .degrees_of_freedom = 20.0};
  WriteCellFile(cell, folder + "/cell.json");
  return folder;
}

TEST(Fly, AnEnsembleSaysHowFarTheOutcomeIsKnown) {
  const auto folder = FolderWithUncertainCell();
  const auto fly = [&](std::vector<std::string> more) {
    std::vector<std::string> arguments{
        "fly", "hover", "--cell", "cell.json", "--duration", "5", "--summary", "s.json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return RunLipoid(folder, arguments);
  };
  ASSERT_EQ(fly({}).exit_code, 0);
  const auto alone = ReadJson(folder, "s.json");
  EXPECT_FALSE(alone.contains("ensemble"));
  const auto run = fly({"--ensemble", "40", "--seed", "2"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  // The estimate itself is flown as ever.
  EXPECT_EQ(summary.at("minimum_voltage_V"), alone.at("minimum_voltage_V"));
  const auto ensemble = summary.at("ensemble");
  EXPECT_EQ(ensemble.at("cells"), 40);
  EXPECT_EQ(ensemble.at("seed"), 2);
  EXPECT_EQ(ensemble.at("completed"), 40);
  EXPECT_EQ(ensemble.at("crashed"), 0);
  EXPECT_EQ(ensemble.at("battery_empty"), 0);
  EXPECT_EQ(ensemble.at("off_course"), 0);
  for (const char* key :
       {"final_soc", "minimum_voltage_V", "simulated_s", "mse_altitude_m2", "charge_C"}) {
    const auto interval = ensemble.at("interval_95").at(key);
    ASSERT_EQ(interval.size(), 2U) << key;
    EXPECT_LE(interval[0].get<double>(), interval[1].get<double>()) << key;
  }
  const auto& volts = ensemble.at("interval_95").at("minimum_voltage_V");
  EXPECT_LT(volts[0].get<double>(), alone.at("minimum_voltage_V").get<double>());
  EXPECT_GT(volts[1].get<double>(), alone.at("minimum_voltage_V").get<double>());
  // 20 mOhm at a few amperes, twice to either side.
  EXPECT_GT(volts[1].get<double>() - volts[0].get<double>(), 0.05);
  EXPECT_NE(run.out.find("40 cells drawn"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("completed 40, crashed 0, battery empty 0"), std::string::npos) << run.out;
  // The same on one thread.
  ASSERT_EQ(fly({"--ensemble", "40", "--seed", "2", "--threads", "1"}).exit_code, 0);
  EXPECT_EQ(ReadJson(folder, "s.json").at("ensemble"), ensemble);
}

TEST(Fly, AnEnsembleNeedsACellThatSaysHowUncertainItIs) {
  const auto folder = TestFolder();
  auto run = RunLipoid(folder, {"fly", "hover", "--ensemble", "10"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_EQ(FirstLineWithBreak(run.err),
            "gifi-600mAh-1:1:1: error: expected the key 'uncertainty' for --ensemble, found none: "
            "identify the cell again with this version of lipoid, or leave --ensemble out\n");
  for (const std::string command : {"fly hover", "simulate"}) {
    std::ofstream(folder + "/current.csv") << "time_s,current_A\n0,0\n1,1\n2,1\n";
    std::vector<std::string> one{"fly", "hover", "--ensemble", "1"};
    if (command == "simulate")
      one = {"simulate", "gifi-600mAh-1", "--current", "current.csv", "--ensemble", "1", "-o", "x"};
    run = RunLipoid(folder, one);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_NE(run.err.find("option --ensemble: expected at least 2 cells, found 1, which has no "
                           "interval; 200 place its ends well, and 0 draws none"),
              std::string::npos)
        << run.err;
  }
  run = RunLipoid(folder, {"fly", "hover", "--xi", "1", "--ensemble", "10"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(FirstLineWithBreak(run.err),
            "lipoid fly: error: option --ensemble is for a cell; an ideal source has no "
            "uncertainty\n");
}

TEST(Fly, SaysWhatDoesNotGoTogether) {
  const auto folder = TestFolder();
  const auto error = [&](std::vector<std::string> options) {
    options.insert(options.begin(), "fly");
    const auto run = RunLipoid(folder, options);
    return std::to_string(run.exit_code) + " " + FirstLineWithBreak(run.err);
  };
  EXPECT_EQ(error({"hover", "--battery", "ideal", "--cell", "gifi-600mAh-1"}),
            "2 lipoid fly: error: options --battery ideal and --cell: give one of them\n");
  EXPECT_EQ(error({"hover", "--battery", "cell", "--xi", "0.9"}),
            "2 lipoid fly: error: option --xi is for an ideal source: a cell has its own voltage. "
            "Give --battery ideal, or leave --xi out\n");
  EXPECT_EQ(error({"hover", "--xi", "1", "--initial-soc", "0.5"}),
            "2 lipoid fly: error: options --initial-soc and --initial-voltage-V are for a cell; an "
            "ideal source has --xi\n");
  EXPECT_EQ(
      error({"hover", "--xi", "1", "--health", "0.9"}),
      "2 lipoid fly: error: options --capacity-Ah, --health and --resistance-factor are for a cell; an ideal "
      "source does not run empty and has no resistance\n");
  EXPECT_EQ(error({"hover", "--payload-g", "-5"}).substr(0, 2), "2 ");
  EXPECT_EQ(error({"waypoints"}),
            "2 lipoid fly: error: maneuver waypoints needs a file of places: --waypoints FILE\n");
  EXPECT_EQ(error({"endurance", "--xi", "1"}),
            "2 lipoid fly: error: maneuver endurance ends with an empty battery, and an ideal "
            "source is never empty: give --duration\n");
  EXPECT_EQ(error({"hover", "--wind", "1,2,3,4"}),
            "2 lipoid fly: error: option --wind: expected one to three numbers X,Y,Z, found "
            "'1,2,3,4'\n");
  EXPECT_EQ(error({"hover", "--wind", "strong"}),
            "2 lipoid fly: error: option --wind: expected a number, -60 .. 60, found 'strong'\n");
  EXPECT_EQ(error({"hover", "--set", "square.side_m=2"}),
            "2 lipoid fly: error: option --set square.side_m: the maneuver is hover\n");
  EXPECT_NE(
      error({"square", "--set", "square.side_m=wide"}).find("expected a number, 0.01 .. 10000"),
      std::string::npos);
  EXPECT_NE(error({"loop"}).find("unknown maneuver 'loop'"), std::string::npos);
  EXPECT_EQ(error({"hover", "--cell", "none.json"}).substr(0, 2), "3 ");
  EXPECT_EQ(error({"hover", "--initial-soc", "-0.1"}).substr(0, 2), "2 ");
  EXPECT_TRUE(FilesIn(folder).empty());
}

TEST(Fly, ManeuversTakeOptionsOfTheirOwn) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"fly",
                              "hover",
                              "--battery",
                              "ideal",
                              "--duration",
                              "1",
                              "--set",
                              "hover.altitude_m=3",
                              "-o",
                              "f.csv",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("maneuver_options").at("altitude_m"), "3");
  const auto log = ReadText(folder + "/f.csv");
  EXPECT_NE(log.find(",3,"), std::string::npos) << "the height that was asked for";
}

TEST(Fly, AFailedRunWritesNothing) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"fly", "hover", "--vehicle", "none.toml", "-o", "f.csv"});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_TRUE(FilesIn(folder).empty());
}

TEST(Fly, TheSameSeedWritesTheSameBytes) {
  const auto folder = TestFolder();
  for (const char* name : {"a.csv", "b.csv"}) {
    const auto run = RunLipoid(folder,
                               {"fly",
                                "square",
                                "--estimate",
                                "--gusts",
                                "2",
                                "--seed",
                                "5",
                                "--duration",
                                "6",
                                "--threads",
                                name[0] == 'a' ? "1" : "2",
                                "-o",
                                name});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  EXPECT_EQ(ReadTextFile(folder + "/a.csv"), ReadTextFile(folder + "/b.csv"));
}

TEST(Fly, SaysBeforeTakeOffThatALoopIsUnstable) {
  const auto folder = TestFolder();
  auto run = RunLipoid(folder,
                       {"fly",
                        "hover",
                        "--gains",
                        "unaware",
                        "--xi",
                        "0.8",
                        "--duration",
                        "1",
                        "--summary",
                        "s.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string first = FirstLineWithBreak(run.err);
  EXPECT_EQ(first.find("the attitude loop is unstable at xi = 0.8 (take-off): its error doubles"),
            0U)
      << first;
  EXPECT_NE(run.err.find("the altitude loop rings at 0.787 rad/s, damping 0.051"),
            std::string::npos)
      << run.err;
  const auto loops = ReadJson(folder, "s.json").at("loops");
  ASSERT_EQ(loops.size(), 4U);
  EXPECT_EQ(loops[1].at("loop"), "attitude");
  EXPECT_FALSE(loops[1].at("stable").get<bool>());
  EXPECT_TRUE(loops[1].at("phase_margin_deg").is_null());
  EXPECT_GT(loops[2].at("phase_margin_deg").get<double>(), 40.0);
}

// F450: the thesis' gains are for faster motors.
std::string FolderWithF450() {
  auto folder = TestFolder();
  WriteFileAtomically(
      folder + "/f450.toml",
      "name = \"f450-like\"\nmass_kg = 1.2\ninertia_kg_m2 = [0.0121, 0.0121, 0.0215]\n"
      "arm_m = 0.225\nthrust_coefficient_N_s2 = 1.07e-5\n"
      "torque_coefficient_N_m_s2 = 1.67e-7\nmotor_constant_N_m_per_A = 0.01038\n"
      "armature_resistance_Ohm = 0.13\nfriction_N_m_s = 5e-6\n"
      "rotor_inertia_kg_m2 = 4e-5\nnominal_voltage_V = 12.6\n");
  return folder;
}

TEST(Fly, GainsOfOtherVehiclesArePlacedByTheirMotors) {
  const auto folder = FolderWithF450();
  auto run = RunLipoid(folder,
                       {"fly",
                        "square",
                        "--vehicle",
                        "f450.toml",
                        "--xi",
                        "0.9",
                        "--estimate",
                        "--summary",
                        "s.json"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(
      FirstLineWithBreak(run.err),
      "gains placed from the motors' lag of 42.1 ms: poles of the attitude at 4.75 rad/s, yaw "
      "1.29, altitude 2.37, position 1.19\n");
  EXPECT_EQ(ReadJson(folder, "s.json").at("gains"), "placed");
  run = RunLipoid(folder,
                  {"fly",
                   "hover",
                   "--vehicle",
                   "f450.toml",
                   "--xi",
                   "0.75",
                   "--gains",
                   "unaware",
                   "--duration",
                   "1"});
  EXPECT_NE(run.err.find("--gains placed computes gains from the lag of this vehicle's motors\n"),
            std::string::npos)
      << run.err;
  run = RunLipoid(
      folder, {"fly", "square", "--vehicle", "f450.toml", "--xi", "0.9", "--controller", "lqr"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(Design, OfARegulatorSaysWhatEachVoltageCosts) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"design",
                              "altitude",
                              "--controller",
                              "lqr",
                              "--aware",
                              "--xi",
                              "0.8:0.1:1",
                              "--optimizer",
                              "levenberg-marquardt",
                              "--check",
                              "never",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("controller"), "lqr");
  EXPECT_TRUE(summary.at("stable").get<bool>());
  ASSERT_EQ(summary.at("costs").size(), 3U);
  double sum = 0.0;
  for (const auto& cost : summary.at("costs")) sum += cost.get<double>();
  EXPECT_NEAR(sum, summary.at("cost").get<double>(), 1e-12 * sum);
}

TEST(Design, GainsWhereASearchStoppedAreNoAnswer) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"design",
                              "altitude",
                              "--xi",
                              "0.8:0.1:1",
                              "--optimizer",
                              "nelder-mead",
                              "--set",
                              "nelder-mead.iterations_per_variable=1",
                              "--check",
                              "never"});
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_NE(FirstLineWithBreak(run.err).find("nelder-mead did not converge ("), std::string::npos)
      << run.err;
}

TEST(List, KnowsManeuvers) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"list", "maneuvers", "--summary", "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("maneuvers").size(), 6U);
  EXPECT_NE(run.out.find("Fig 6.7"), std::string::npos);
}

TEST(Poles, PrintsThreeWaysForARange) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"poles",
                              "altitude",
                              "--vehicle",
                              "mambo-thesis",
                              "--gains",
                              "unaware",
                              "--xi",
                              "0.8:0.01:1",
                              "--summary",
                              "s.json",
                              "-o",
                              "p.csv"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto rows = ReadJson(folder, "s.json").at("rows");
  ASSERT_EQ(rows.size(), 21U);
  EXPECT_EQ(rows.back().at("xi"), 1.0);
  EXPECT_EQ(rows[2].at("xi"), 0.82);
  EXPECT_EQ(rows[0].at("poles").size(), 3U);
  EXPECT_EQ(rows[0].at("poles_quasistatic").size(), 3U);
  EXPECT_EQ(rows[0].at("poles_full").size(), 4U);
  EXPECT_EQ(rows[0].at("poles")[0].size(), 2U);
  EXPECT_NEAR(rows.back().at("kappa").get<double>(), 1.0, 1e-12);
  const std::string csv = ReadTextFile(folder + "/p.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + 21 * 10);
}

TEST(Poles, SaysWhatARangeIs) {
  const auto folder = TestFolder();
  const auto error = [&](const char* range) {
    return FirstLineWithBreak(RunLipoid(folder, {"poles", "attitude", "--xi", range}).err);
  };
  EXPECT_EQ(error("0.8:1"),
            "lipoid poles: error: option --xi: expected FIRST:STEP:LAST or one number, found "
            "'0.8:1'\n");
  EXPECT_EQ(error("0.8:-0.1:1"),
            "lipoid poles: error: option --xi: expected FIRST:STEP:LAST or one number, found "
            "'0.8:-0.1:1': the step does not lead from the first to the last\n");
  EXPECT_EQ(error("0.8:1e-9:1"),
            "lipoid poles: error: option --xi: expected FIRST:STEP:LAST or one number, found "
            "'0.8:1e-9:1': more than a million numbers\n");
  EXPECT_EQ(error("0.8:1:0.9"),
            "lipoid poles: error: option --xi: expected FIRST:STEP:LAST or one number, found "
            "'0.8:1:0.9': the first step leads beyond the last\n");
  EXPECT_EQ(error("0.8,0.9"),
            "lipoid poles: error: option --xi: expected FIRST:STEP:LAST or one number, found "
            "'0.8,0.9': a comma neither separates numbers nor parts their digits here\n");
  EXPECT_NE(error("0.8:0:1").find("error"), std::string::npos);
  EXPECT_NE(error("nan").find("found 'nan'"), std::string::npos);
  EXPECT_EQ(RunLipoid(folder, {"poles", "yaw"}).exit_code, 2);
}

TEST(Design, WritesGainsThatFly) {
  const auto folder = TestFolder();
  auto run = RunLipoid(folder,
                       {"design",
                        "altitude",
                        "--aware",
                        "--optimizer",
                        "levenberg-marquardt",
                        "--xi",
                        "0.8:0.1:1",
                        "-o",
                        "g.json",
                        "--summary",
                        "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  for (const char* key : {"cost", "evaluations", "wall_s"}) {
    EXPECT_TRUE(summary.at(key).is_number()) << key;
  }
  for (const char* key : {"proportional", "integral", "derivative"}) {
    EXPECT_TRUE(summary.at("gains").at(key).is_number()) << key;
  }
  EXPECT_TRUE(summary.at("longer_run").at("gap_percent").is_number());
  EXPECT_LT(summary.at("cost"), summary.at("start").at("cost"));
  EXPECT_NE(run.err.find("a run ten times longer"), std::string::npos) << run.err;
  run = RunLipoid(folder, {"fly", "hover", "--gains", "g.json", "--duration", "2"});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST(Design, SaysWhichBoundsDecided) {
  const auto folder = TestFolder();
  const auto design = [&](const std::string& bound) {
    return RunLipoid(folder,
                     {"design",
                      "altitude",
                      "--optimizer",
                      "levenberg-marquardt",
                      "--check",
                      "never",
                      "--set",
                      "design.proportional_bound=" + bound,
                      "--set",
                      "design.derivative_bound=3",
                      "--summary",
                      "s.json"});
  };
  const auto narrow = design("2");
  EXPECT_EQ(ReadJson(folder, "s.json").at("at_bound"),
            (std::vector<std::string>{"proportional", "derivative"}));
  EXPECT_NE(
      narrow.err.find("the search ended at its upper bound: proportional = 2, derivative = 3"),
      std::string::npos)
      << narrow.err;
  EXPECT_NE(narrow.err.find("--set design.derivative_bound=..."), std::string::npos) << narrow.err;
  (void)design("1000");
  EXPECT_EQ(ReadJson(folder, "s.json").at("at_bound"), (std::vector<std::string>{"derivative"}));
}

TEST(Design, SaysWhatIsWrong) {
  const auto folder = TestFolder();
  EXPECT_EQ(RunLipoid(folder, {"design", "yaw"}).exit_code, 2);
  EXPECT_EQ(
      FirstLineWithBreak(
          RunLipoid(folder, {"design", "altitude", "--aware", "--weights", "1,2"}).err),
      "lipoid design: error: option --weights: expected 21 numbers, one for each xi, found 2\n");
  EXPECT_EQ(
      FirstLineWithBreak(
          RunLipoid(folder, {"design", "altitude", "--xi", "0.9:0.1:1", "--weights", "0,0"}).err),
      "lipoid design: error: option --weights: expected a number above 0 among them, found 0,0, "
      "by which no gains are better than others\n");
  EXPECT_EQ(RunLipoid(folder, {"design", "altitude", "--optimizer", "guess"}).exit_code, 2);
}

// docs/notation.md: K_e, K_eI, K_edot.
TEST(Fly, AGainHasOneName) {
  const auto folder = TestFolder();
  for (const auto& arguments : {std::vector<std::string>{"list", "gains"},
                                std::vector<std::string>{"poles", "altitude", "--xi", "1"}}) {
    const auto run = RunLipoid(folder, arguments);
    EXPECT_NE((run.out + run.err).find("K_eI"), std::string::npos) << run.out << run.err;
    EXPECT_EQ((run.out + run.err).find("K_I"), std::string::npos) << run.out << run.err;
  }
}

// A flight has no rows.
TEST(Fly, HelpSaysWhereAFlightStarts) {
  const auto help = RunLipoid(TestFolder(), {"fly", "--help"});
  EXPECT_NE(help.out.find("state of charge at the start; 1 is full"), std::string::npos)
      << help.out;
}

// `endurance` hovers with the same pack and vehicle, by its own steps and without a controller.
TEST(Fly, CarriesAPayloadOnAnAgedPackOfAnotherSize) {
  const std::string folder = TestFolder();
  const std::vector<std::string> pack{
      "--vehicle", "f450", "--cell", "grepow-32Ah-1", "--series", "4", "--capacity-Ah", "5"};
  const auto flown = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"fly", "hover", "--duration", "60", "--summary", "s.json"};
    words.insert(words.end(), pack.begin(), pack.end());
    words.insert(words.end(), more.begin(), more.end());
    const auto run = RunLipoid(folder, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    Json summary = ReadJson(folder, "s.json");
    summary["said"] = run.err;
    return summary;
  };
  const std::vector<std::string> asked{
      "--payload-g", "300", "--health", "0.8", "--resistance-factor", "1.5"};
  const Json bare = flown({});
  const Json laden = flown(asked);
  EXPECT_NEAR(laden.at("mass_kg").get<double>() - bare.at("mass_kg").get<double>(), 0.3, 1e-12);
  EXPECT_DOUBLE_EQ(bare.at("capacity_Ah").get<double>(), 5.0);
  EXPECT_DOUBLE_EQ(laden.at("capacity_Ah").get<double>(), 4.0);
  EXPECT_NE(
      laden.at("said").get<std::string>().find(
          "f450 with 300 g more on grepow-32Ah-1 in a size of 5 Ah with 0.8 of its capacity and 1.5 times "
          "its resistance"),
      std::string::npos)
      << laden.at("said");
  // The same charge lasts the same time and leads to the same voltage.
  std::vector<std::string> hovering{"endurance",
                                    "--reserve",
                                    fmt::format("{}", laden.at("remaining_soc").get<double>()),
                                    "--summary",
                                    "e.json"};
  hovering.insert(hovering.end(), pack.begin(), pack.end());
  hovering.insert(hovering.end(), asked.begin(), asked.end());
  const auto run = RunLipoid(folder, hovering);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json endurance = ReadJson(folder, "e.json");
  EXPECT_NEAR(endurance.at("minutes").get<double>(), 1.0, 0.005);
  EXPECT_NEAR(endurance.at("landing_voltage_V").get<double>(),
              laden.at("final_voltage_V").get<double>(),
              0.005);
  // The share that is left goes with the charge of the aged pack.
  const double used = 1.0 - laden.at("remaining_soc").get<double>();
  const double alpha_C = laden.at("charge_C").get<double>() / used;
  const double bare_alpha_C =
      bare.at("charge_C").get<double>() / (1.0 - bare.at("remaining_soc").get<double>());
  EXPECT_NEAR(alpha_C / bare_alpha_C, 0.8, 0.005);
}

// A vehicle for four cells on one: it says so, and on four it hovers at its own current.
TEST(Fly, TakesThePackThatTheVehicleIsMadeFor) {
  const std::string folder = TestFolder();
  const auto one = RunLipoid(
      folder, {"fly", "hover", "--vehicle", "f450", "--cell", "grepow-32Ah-1", "--duration", "3"});
  EXPECT_EQ(one.exit_code, 1);
  EXPECT_NE(one.err.find("give --series 4"), std::string::npos) << one.err;
  const auto four = RunLipoid(folder,
                              {"fly",
                               "hover",
                               "--vehicle",
                               "f450",
                               "--cell",
                               "grepow-32Ah-1",
                               "--series",
                               "4",
                               "--duration",
                               "3",
                               "--summary",
                               "s.json"});
  EXPECT_EQ(four.exit_code, 0) << four.err;
  EXPECT_NE(four.err.find("is the capacity in mAh"), std::string::npos) << four.err;  // 490 Wh
  // The same hover as of equilibrium: lipoid vehicle says 201 W; 32 Ah of cells hold 16 V and more.
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_GT(summary.at("minimum_voltage_V").get<double>(), 15.0);
  EXPECT_NEAR(summary.at("charge_C").get<double>() / 3.0, 13.0, 1.0);
  const auto twelve = RunLipoid(folder,
                                {"fly",
                                 "hover",
                                 "--vehicle",
                                 "f450",
                                 "--cell",
                                 "grepow-32Ah-1",
                                 "--series",
                                 "12",
                                 "--duration",
                                 "1"});
  EXPECT_NE(twelve.err.find("more voltage than they are made for"), std::string::npos)
      << twelve.err;
  const auto mambo = RunLipoid(folder, {"fly", "hover", "--series", "3", "--duration", "1"});
  EXPECT_NE(mambo.err.find("mambo-coupled is made for 1 cell in series, and this pack has 3"),
            std::string::npos)
      << mambo.err;
  const auto ideal = RunLipoid(folder, {"fly", "hover", "--battery", "ideal", "--series", "4"});
  EXPECT_EQ(ideal.exit_code, 2);
  EXPECT_NE(ideal.err.find("are for cells"), std::string::npos) << ideal.err;
}

}  // namespace
}  // namespace lipoid::test
