// lipoid endurance, end to end. What it finds: tests/model/flight/endurance_test.cc.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "model/core/atomic_file.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

constexpr const char* kCell = "gifi-600mAh-1";

Json SummaryOf(const std::string& folder, std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "endurance");
  arguments.insert(arguments.end(), {"--summary", "s.json"});
  const auto run = RunLipoid(folder, arguments);
  EXPECT_EQ(run.exit_code, 0) << run.err;
  return ReadJson(folder, "s.json");
}

TEST(EnduranceCommand, SaysTimeUseAndLandingVoltage) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"endurance",
                              "--vehicle",
                              "mambo-physical",
                              "--cell",
                              kCell,
                              "--reserve",
                              "50%",
                              "--summary",
                              "s.json"});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("ended_by"), "reserve");
  EXPECT_NEAR(summary.at("charge_Ah").get<double>(), 0.5 * 1353.6 / 3600.0, 1e-9);
  EXPECT_NEAR(summary.at("landing_rest_voltage_V").get<double>(), 3.82, 1e-9);
  EXPECT_TRUE(summary.at("minutes_interval_95").is_null());
  EXPECT_TRUE(summary.at("hottest_degC").is_null());
  EXPECT_NE(run.out.find("The reserve of 50 % of the charge was reached"), std::string::npos)
      << run.out;
  EXPECT_NE(run.err.find("no intervals"), std::string::npos) << run.err;
}

// A camera drone on a cell of 5.2 Ah.
std::vector<std::string> Camera(const std::vector<std::string>& more) {
  std::vector<std::string> words{
      "endurance", "--vehicle", "camera-10in", "--cell", "grepow-32Ah-1", "--capacity-Ah", "5.2"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

// The density of the air is the one that a hover feels.
TEST(EnduranceCommand, SaysWhichOfTheAirAHoverDoesNotFeel) {
  const auto folder = TestFolder();
  const auto with = [&](const std::string& set) {
    const auto run = RunLipoid(folder, Camera({"--series", "4", "--set", set}));
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err.find("change nothing in a hover") != std::string::npos;
  };
  EXPECT_FALSE(with("air.air_density_kg_per_m3=0.9"));
  EXPECT_TRUE(with("air.flat_plate_area_m2=0.1"));
}

// 5200 mAh given as Ah: 77 kWh on 1.8 kg.
TEST(EnduranceCommand, AsksWhetherACapacityIsInmAh) {
  const auto run = RunLipoid(TestFolder(),
                             {"endurance",
                              "--vehicle",
                              "camera-10in",
                              "--cell",
                              "grepow-32Ah-1",
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5200"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(
      run.err.find("more than the 1.8 kg of camera-10in with its pack: is the capacity in mAh"),
      std::string::npos)
      << run.err;
}

// A hover within hundredths of a volt of what the pack gives.
TEST(EnduranceCommand, TellsTwoVoltagesApart) {
  const auto run = RunLipoid(TestFolder(),
                             {"endurance",
                              "--vehicle",
                              "f450",
                              "--cell",
                              "grepow-32Ah-1",
                              "--series",
                              "4",
                              "--capacity-Ah",
                              "5",
                              "--payload-g",
                              "1500"});
  const auto at = run.out.find("The motors need ");
  ASSERT_NE(at, std::string::npos) << run.out;
  double needed_V = 0.0;
  double given_V = 0.0;
  ASSERT_EQ(
      std::sscanf(
          run.out.c_str() + at, "The motors need %lf V, more than the %lf V", &needed_V, &given_V),
      2);
  EXPECT_GT(needed_V, given_V);
}

// The page is made of the summary: what is said beside the numbers is in it, also of a quiet run.
TEST(EnduranceCommand, TheSummaryHoldsWhatIsSaid) {
  const auto folder = TestFolder();
  std::vector<std::string> arguments = Camera(
      {"--series", "6", "--mission", "cruise", "--ambient-degC", "20", "--summary", "s.json"});
  const auto said = RunLipoid(folder, arguments);
  ASSERT_EQ(said.exit_code, 0) << said.err;
  const auto summary = ReadJson(folder, "s.json");
  ASSERT_EQ(summary.at("sentences").size(), 2U);
  for (const auto& sentence : summary.at("sentences"))
    EXPECT_NE(said.out.find(sentence.get<std::string>()), std::string::npos) << sentence;
  ASSERT_EQ(summary.at("messages").size(), 4U) << summary.at("messages");
  for (const auto& message : summary.at("messages"))
    EXPECT_NE(said.err.find(message.get<std::string>()), std::string::npos) << message;
  arguments.emplace_back("--quiet");
  const auto quiet = RunLipoid(folder, arguments);
  EXPECT_EQ(quiet.err, "");
  EXPECT_EQ(ReadJson(folder, "s.json").at("messages"), summary.at("messages"));
}

// A of the model is what diffusion lets out under load; the share that is left is a count of charge.
TEST(EnduranceCommand, FlyAndEnduranceTellTheSameShareOfTheChargeLeft) {
  const auto folder = TestFolder();
  const auto flown = RunLipoid(
      folder, {"fly", "hover", "--cell", kCell, "--duration", "60", "--summary", "flight.json"});
  ASSERT_EQ(flown.exit_code, 0) << flown.err;
  const auto flight = ReadJson(folder, "flight.json");
  const double left = flight.at("remaining_soc").get<double>();
  // 1353.6 C is alpha of the cell.
  EXPECT_NEAR(left, 1.0 - flight.at("charge_C").get<double>() / 1353.6, 1e-3);
  EXPECT_GT(left, flight.at("final_soc").get<double>() + 0.01);
  EXPECT_NE(flown.out.find("charge left"), std::string::npos) << flown.out;
}

TEST(EnduranceCommand, APackThatCannotFlySaysSoFirst) {
  const auto folder = TestFolder();
  const auto run =
      RunLipoid(folder, Camera({"--series", "4", "--health", "0.01", "--summary", "s.json"}));
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_TRUE(run.out.starts_with("This pack cannot carry this mission")) << run.out;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_TRUE(summary.at("sentences").at(0).get<std::string>().starts_with("This pack cannot"));
  EXPECT_LT(summary.at("landing_voltage_V").get<double>(), 4 * 4.2);
}

TEST(EnduranceCommand, StandardErrorsGiveIntervals) {
  const auto folder = TestFolder();
  const auto summary = SummaryOf(folder,
                                 {"--vehicle",
                                  "mambo-physical",
                                  "--cell",
                                  kCell,
                                  "--power-factor",
                                  "1+-5%",
                                  "--ensemble",
                                  "50",
                                  "--set",
                                  "step_s=0.1"});
  const auto interval = summary.at("minutes_interval_95").get<std::vector<double>>();
  ASSERT_EQ(interval.size(), 2U);
  EXPECT_LT(interval[0], summary.at("minutes").get<double>());
  EXPECT_GT(interval[1], summary.at("minutes").get<double>());
  EXPECT_EQ(summary.at("ensemble").at("flights"), 50);
  EXPECT_EQ(summary.at("ensemble").at("cells_drawn"), false);
  EXPECT_EQ(summary.at("power_factor").at("standard_error"), 0.05);
}

// 5 % of 200 g are 10 g, not a twentieth of a gram; a share and its error are both in percent, or neither is.
TEST(EnduranceCommand, PercentOfAQuantityAreOfItsValue) {
  const auto folder = TestFolder();
  const auto run = [&](const std::string& option, const std::string& text) {
    return RunLipoid(folder,
                     {"endurance",
                      "--vehicle",
                      "mambo-physical",
                      "--cell",
                      kCell,
                      "--ensemble",
                      "2",
                      "--set",
                      "step_s=0.1",
                      option,
                      text,
                      "--summary",
                      "s.json"});
  };
  const auto error_of = [&](const std::string& key) {
    return ReadJson(folder, "s.json").at(key).at("standard_error").get<double>();
  };
  EXPECT_EQ(run("--payload-g", "4+-5%").exit_code, 0);
  EXPECT_NEAR(error_of("payload_kg"), 2e-4, 1e-15);
  EXPECT_EQ(run("--resistance-factor", "1.5+-20%").exit_code, 0);
  EXPECT_NEAR(error_of("resistance_factor"), 0.3, 1e-15);
  EXPECT_EQ(run("--health", "80%+-5%").exit_code, 0);
  EXPECT_EQ(error_of("health"), 0.05);
  const std::vector<std::array<std::string, 3>> wrong{
      {"--payload-g",
       "50%",
       "option --payload-g: expected a number in the unit of the option, none in percent, found '50%'"},
      {"--ambient-degC",
       "50%",
       "option --ambient-degC: expected a number in the unit of the option, none in percent"},
      {"--ambient-degC",
       "20+-5%",
       "expected a standard error in the unit of the option, none in percent"},
      {"--health",
       "80%+-5",
       "expected a standard error in percent beside a share in percent, such as 80%+-5%"},
      {"--health", "0.8+-", "expected a standard error behind the sign"}};
  for (const auto& [option, text, message] : wrong) {
    const auto refused = run(option, text);
    EXPECT_EQ(refused.exit_code, 2) << text;
    EXPECT_NE(refused.err.find(message), std::string::npos) << refused.err;
  }
}

TEST(EnduranceCommand, AColdPackWarmsAndFliesShorter) {
  const auto folder = TestFolder();
  const std::vector<std::string> mild{
      "--vehicle", "mambo-physical", "--cell", kCell, "--ambient-degC", "25"};
  std::vector<std::string> cold = mild;
  cold.back() = "0";
  const auto warm = SummaryOf(folder, mild);
  const auto chilly = SummaryOf(folder, cold);
  EXPECT_LT(chilly.at("minutes").get<double>(), warm.at("minutes").get<double>());
  EXPECT_GT(chilly.at("hottest_degC").get<double>(), 1.0);
  EXPECT_EQ(chilly.at("temperature_assumed"), true);
}

TEST(EnduranceCommand, APowerIsFlownAgainAndAgainOrOnce) {
  const auto folder = TestFolder();
  WriteText(folder + "/power.csv", "time_s,power_W\n0,0\n10,8\n20,4\n");
  const auto all =
      SummaryOf(folder, {"--cell", kCell, "--mission", "power=power.csv", "--reserve", "0.5"});
  EXPECT_EQ(all.at("ended_by"), "reserve");
  // 6 W on average at 3.99 V of the curve less 0.08 V of diffusion and 0.21 V of the resistance.
  EXPECT_NEAR(all.at("minutes").get<double>(), 0.5 * 1353.6 * 3.70 / 6.0 / 60.0, 0.2);
  EXPECT_EQ(all.at("rounds"), std::floor(all.at("minutes").get<double>() * 3.0));
  EXPECT_TRUE(all.at("level_flight").is_null());
  const auto once = SummaryOf(folder, {"--cell", kCell, "--mission", "power=power.csv", "--once"});
  EXPECT_EQ(once.at("ended_by"), "mission-done");
  EXPECT_NEAR(once.at("minutes").get<double>(), 20.0 / 60.0, 1e-12);
  EXPECT_NEAR(once.at("energy_Wh").get<double>(), 120.0 / 3600.0, 1e-9);
}

// What a flight took from its battery, flown once more.
TEST(EnduranceCommand, AFlightLogIsAMission) {
  const auto folder = TestFolder();
  const auto flown = RunLipoid(folder,
                               {"fly",
                                "altitude-steps",
                                "--cell",
                                kCell,
                                "--duration",
                                "20",
                                "-o",
                                "flight.csv",
                                "--summary",
                                "flight.json"});
  ASSERT_EQ(flown.exit_code, 0) << flown.err;
  const auto once = SummaryOf(folder, {"--cell", kCell, "--mission", "power=flight.csv", "--once"});
  // The row that was not yet flown is one step of 5 ms; the power is that at the start of each step.
  const double charge_C = ReadJson(folder, "flight.json").at("charge_C").get<double>();
  EXPECT_NEAR(3600.0 * once.at("charge_Ah").get<double>(), charge_C, 2e-3 * charge_C);
}

constexpr const char* kQuadrotor = R"(
name = "quadrotor"
summary = "1.2 kg"
mass_kg = 1.2
inertia_kg_m2 = [0.01, 0.01, 0.018]
arm_m = 0.225
thrust_coefficient_N_s2 = 1.1e-5
torque_coefficient_N_m_s2 = 1.7e-7
motor_constant_N_m_per_A = 0.0104
armature_resistance_Ohm = 0.12
friction_N_m_s = 8e-6
rotor_inertia_kg_m2 = 5e-5
nominal_voltage_V = 11.1
propeller_diameter_m = 0.239
)";

// A log without a header is a mission where its columns are numbered.
TEST(EnduranceCommand, SaysHowALogOfPowersIsRead) {
  const auto folder = TestFolder();
  std::string text;
  for (int k = 0; k < 600; ++k) text += std::to_string(1000 * k) + ",3.9,1500\n";
  WriteFileAtomically(folder + "/p.csv", text);
  const auto summary = SummaryOf(folder,
                                 {"--cell",
                                  kCell,
                                  "--mission",
                                  "power=p.csv",
                                  "--once",
                                  "--columns",
                                  "time_s=1",
                                  "voltage_V=2",
                                  "current_A=3",
                                  "--units",
                                  "ms,mA,V",
                                  "--current-sign",
                                  "discharge-positive"});
  EXPECT_EQ(summary.at("ended_by"), "mission-done");
  // 3.9 V times 1.5 A for 599 s.
  EXPECT_NEAR(summary.at("energy_Wh").get<double>(), 3.9 * 1.5 * 599.0 / 3600.0, 1e-3);
}

TEST(EnduranceCommand, APackIsChargedNoFurtherThanFull) {
  const auto folder = TestFolder();
  WriteFileAtomically(folder + "/p.csv", "time_s,power_W\n0,-2\n36000,-2\n");
  const auto run = RunLipoid(
      folder,
      {"endurance", "--cell", kCell, "--mission", "power=p.csv", "--once", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_NE(run.out.find("The powers of the mission charge the pack beyond full"),
            std::string::npos)
      << run.out;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("ended_by"), "full");
  // A pack that begins beyond full may take a little back on its way.
  WriteFileAtomically(folder + "/q.csv", "time_s,power_W\n0,-1\n10,-1\n600,2\n");
  EXPECT_EQ(
      SummaryOf(folder,
                {"--cell", kCell, "--mission", "power=q.csv", "--once", "--initial-soc", "1.1"})
          .at("ended_by"),
      "mission-done");
}

TEST(EnduranceCommand, CruiseSaysTheBestSpeeds) {
  const auto folder = TestFolder();
  WriteText(folder + "/quadrotor.toml", kQuadrotor);
  const std::vector<std::string> cruise{"--vehicle",
                                        "quadrotor.toml",
                                        "--cell",
                                        "grepow-32Ah-1",
                                        "--series",
                                        "3",
                                        "--health",
                                        "0.15",
                                        "--mission",
                                        "cruise"};
  const auto far = SummaryOf(folder, cruise);
  const auto& speeds = far.at("speeds");
  EXPECT_EQ(far.at("level_flight").at("airspeed_m_per_s"), speeds.at("best_range_m_per_s"));
  EXPECT_LT(speeds.at("best_endurance_m_per_s").get<double>(),
            speeds.at("best_range_m_per_s").get<double>());
  EXPECT_LE(speeds.at("best_range_m_per_s").get<double>(),
            speeds.at("fastest_m_per_s").get<double>());
  EXPECT_NEAR(
      far.at("range_km").get<double>(),
      0.06 * speeds.at("best_range_m_per_s").get<double>() * far.at("minutes").get<double>(),
      1e-9);
  std::vector<std::string> slow = cruise;
  slow.insert(slow.end(), {"--airspeed-m-per-s", "best-endurance"});
  const auto longest = SummaryOf(folder, slow);
  EXPECT_GT(longest.at("minutes").get<double>(), far.at("minutes").get<double>());
  slow.back() = "4+-1";
  slow.insert(slow.end(), {"--ensemble", "40"});
  EXPECT_FALSE(SummaryOf(folder, slow).at("range_km_interval_95").is_null());
  // Level flight of a vehicle whose propellers are not known.
  const auto run = RunLipoid(
      folder, {"endurance", "--vehicle", "mambo-coupled", "--cell", kCell, "--mission", "cruise"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("propeller_diameter_m"), std::string::npos) << run.err;
}

// The pack's label is not what this cell gives.
TEST(EnduranceCommand, SaysHowMuchOfItsNominalCapacityACellGives) {
  const auto flown = [](const std::string& cell) {
    return RunLipoid(
        TestFolder(),
        {"endurance", "--vehicle", "f450", "--cell", cell, "--capacity-Ah", "5", "--series", "4"});
  };
  const auto said = flown("gifi-600mAh-1").err;  // alpha is 1353.6 C, of 0.6 Ah
  EXPECT_NE(
      said.find(
          "gives 62.7 % of its nominal capacity, and so a cell of 5 Ah is taken to give 3.13 Ah: of "
          "one that gives 5 Ah, say --capacity-Ah 7.98"),
      std::string::npos)
      << said;
  EXPECT_EQ(flown("grepow-32Ah-1").err.find("nominal"), std::string::npos);
}

TEST(EnduranceCommand, TablesGoOverAQuantity) {
  const auto folder = TestFolder();
  const auto printed = RunLipoid(
      folder,
      {"endurance", "--vehicle", "f450", "--cell", "gifi-600mAh-1", "--over", "payload-g=0,300"});
  EXPECT_EQ(printed.out.find("95 %"), std::string::npos) << printed.out;
  const auto summary = SummaryOf(
      folder, {"--vehicle", "mambo-physical", "--cell", kCell, "--over", "payload-g=0:5:10"});
  const auto& rows = summary.at("over").at("rows");
  ASSERT_EQ(rows.size(), 3U);
  EXPECT_EQ(rows[0].at("minutes"), summary.at("minutes"));
  EXPECT_EQ(rows[1].at("value"), 5.0);
  const auto loaded =
      SummaryOf(folder, {"--vehicle", "mambo-physical", "--cell", kCell, "--payload-g", "10"});
  EXPECT_EQ(rows[2].at("minutes"), loaded.at("minutes"));
  EXPECT_LT(rows[2].at("minutes"), rows[1].at("minutes"));
}

// The route is flown by the simulator, and its power until the battery ends it.
TEST(EnduranceCommand, ARouteIsFlownUntilTheReserve) {
  const auto folder = TestFolder();
  WriteText(folder + "/route.toml", R"(
[[waypoint]]
altitude_m = 2.0
stay_s = 5.0
[[waypoint]]
altitude_m = 2.0
x_m = 2.0
stay_s = 10.0
[[waypoint]]
altitude_m = 2.0
stay_s = 10.0
)");
  const auto hover =
      SummaryOf(folder, {"--vehicle", "mambo-physical", "--cell", kCell, "--reserve", "0.4"});
  const auto route = SummaryOf(folder,
                               {"--vehicle",
                                "mambo-physical",
                                "--cell",
                                kCell,
                                "--reserve",
                                "0.4",
                                "--mission",
                                "waypoints=route.toml"});
  EXPECT_EQ(route.at("ended_by"), "reserve");
  // Two metres there and back in 25 s take little more than hover does.
  EXPECT_NEAR(route.at("minutes").get<double>(), hover.at("minutes").get<double>(), 0.1);
  EXPECT_EQ(route.at("rounds"), std::floor(route.at("minutes").get<double>() * 60.0 / 25.0));
  EXPECT_NEAR(route.at("range_km").get<double>(), 0.004 * route.at("rounds").get<int>(), 0.005);
}

TEST(EnduranceCommand, APackThatCannotCarryTheMissionIsNoFlight) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             {"endurance",
                              "--vehicle",
                              "mambo-physical",
                              "--cell",
                              kCell,
                              "--payload-g",
                              "200",
                              "--summary",
                              "s.json"});
  EXPECT_EQ(run.exit_code, 1) << run.err;
  EXPECT_EQ(ReadJson(folder, "s.json").at("minutes"), 0.0);
  EXPECT_TRUE(run.out.starts_with(
      "This pack cannot carry this mission: the flight ends after 0 s. Give more cells"))
      << run.out;
  // The pack has the power, but not at a voltage above its cut-off.
  WriteFileAtomically(folder + "/p.csv", "time_s,power_W\n0,29\n60,29\n");
  const auto low = RunLipoid(folder,
                             {"endurance",
                              "--cell",
                              kCell,
                              "--mission",
                              "power=p.csv",
                              "--once",
                              "--summary",
                              "low.json"});
  EXPECT_EQ(low.exit_code, 1) << low.err;
  EXPECT_EQ(ReadJson(folder, "low.json").at("ended_by"), "cut-off");
  EXPECT_TRUE(low.out.starts_with("This pack cannot carry this mission: the flight ends after 1"))
      << low.out;
}

// Neither a charge that is used up at once nor a wait before the load is a flight.
TEST(EnduranceCommand, WhatEndsWithTheLoadIsNoFlight) {
  const auto folder = TestFolder();
  const auto used_up = RunLipoid(folder,
                                 {"endurance",
                                  "--vehicle",
                                  "mambo-physical",
                                  "--cell",
                                  kCell,
                                  "--initial-soc",
                                  "0.02",
                                  "--reserve",
                                  "0",
                                  "--summary",
                                  "s.json"});
  EXPECT_EQ(used_up.exit_code, 1);
  EXPECT_EQ(ReadJson(folder, "s.json").at("ended_by"), "empty");
  EXPECT_TRUE(used_up.out.starts_with("This pack cannot carry this mission")) << used_up.out;
  for (const char* idle_W : {"0", "1"}) {
    std::string rows = "time_s,power_W\n";
    for (int k = 0; k <= 40; ++k) rows += fmt::format("{},{}\n", k, k <= 20 ? idle_W : "50");
    WriteText(folder + "/waits.csv", rows);
    const auto waits = RunLipoid(
        folder,
        {"endurance", "--cell", kCell, "--mission", "power=waits.csv", "--summary", "s.json"});
    EXPECT_EQ(waits.exit_code, 1) << idle_W;
    EXPECT_GT(ReadJson(folder, "s.json").at("minutes"), 20.0 / 60.0);
    EXPECT_TRUE(waits.out.starts_with("This pack cannot carry this mission")) << waits.out;
  }
  // A load that it carries for a while is one.
  std::string rows = "time_s,power_W\n";
  for (int k = 0; k <= 80; ++k) rows += fmt::format("{},{}\n", k, k <= 60 ? "10" : "50");
  WriteText(folder + "/climbs.csv", rows);
  const auto climbs =
      RunLipoid(folder, {"endurance", "--cell", kCell, "--mission", "power=climbs.csv"});
  EXPECT_EQ(climbs.exit_code, 0) << climbs.out;
}

// Under 8 W the battery is below the voltage of 4 W long before the reserve: who landed by it would land in the
// first round.
TEST(EnduranceCommand, OfAVaryingPowerTheChargeSaysWhenToLand) {
  const auto folder = TestFolder();
  WriteText(folder + "/power.csv", "time_s,power_W\n0,0\n10,8\n20,4\n");
  const auto varying =
      SummaryOf(folder, {"--cell", kCell, "--mission", "power=power.csv", "--reserve", "0.5"});
  const std::string said = varying.at("sentences")[0];
  EXPECT_NE(said.find("land when 188 mAh are used; the pack then rests at 3.82 V."),
            std::string::npos)
      << said;  // half of 1353.6 C
  EXPECT_NE(said.find("The voltage in flight does not tell it"), std::string::npos) << said;
  EXPECT_EQ(said.find("falls to"), std::string::npos) << said;
  WriteText(folder + "/even.csv", "time_s,power_W\n0,0\n10,6\n20,6\n");
  const auto even =
      SummaryOf(folder, {"--cell", kCell, "--mission", "power=even.csv", "--reserve", "0.5"});
  EXPECT_NE(even.at("sentences")[0].get<std::string>().find("land when the battery falls to"),
            std::string::npos);
}

// Of iron phosphate a hundredth of a volt is much of the charge, also under a steady load.
TEST(EnduranceCommand, OnAFlatCurveTheChargeSaysWhenToLand) {
  const auto folder = TestFolder();
  Json flat = Json::parse(ReadText(SourcePath("fixtures/cells/gifi-600mAh-1.json")));
  flat["cutoff_V"] = 2.5;
  flat["open_circuit_voltage"] = {{"method", "linear"},
                                  {"soc", {0.0, 0.1, 0.2, 0.35, 0.65, 0.7, 0.95, 1.0}},
                                  {"voltage_V", {2.6, 3.15, 3.23, 3.285, 3.29, 3.325, 3.33, 3.4}}};
  WriteText(folder + "/flat.json", flat.dump());
  WriteText(folder + "/power.csv", "time_s,power_W\n0,2\n60,2\n");
  const auto summary = SummaryOf(
      folder, {"--cell", "flat.json", "--mission", "power=power.csv", "--reserve", "0.5"});
  EXPECT_EQ(
      summary.at("sentences")[0],
      "The reserve of 50 % of the charge was reached: land when 188 mAh are used; the pack then rests at 3.288 V. "
      "The voltage in flight does not tell it: 0.01 V are 60 % of the charge there.");
}

TEST(EnduranceCommand, SaysThatTheWayBackIsNotFlown) {
  const auto folder = TestFolder();
  const std::string there =
      "[[waypoint]]\naltitude_m = 1\n\n[[waypoint]]\nx_m = 3\naltitude_m = 1\nstay_s = 8\n";
  const auto messages = [&](const std::string& route, std::vector<std::string> more) {
    WriteText(folder + "/route.toml", route);
    more.insert(
        more.end(),
        {"--vehicle", "mambo-physical", "--cell", kCell, "--mission", "waypoints=route.toml"});
    return SummaryOf(folder, more).at("messages").dump();
  };
  const std::string said = "the route ends 3 m from where it begins";
  EXPECT_NE(messages(there, {}).find(said), std::string::npos);
  EXPECT_NE(messages(there, {}).find("without the drag of the air"), std::string::npos);
  EXPECT_EQ(messages(there, {"--once"}).find(said), std::string::npos);
  const auto table = RunLipoid(folder,
                               {"endurance",
                                "--vehicle",
                                "mambo-physical",
                                "--cell",
                                kCell,
                                "--mission",
                                "waypoints=route.toml",
                                "--over",
                                "payload-g=0:5:10"});
  EXPECT_EQ(table.exit_code, 2);
  EXPECT_NE(
      table.err.find(
          "option --over: a table flies the mission of a file once, so that payload-g cannot stand in "
          "it; give each a run of its own, with --payload-g"),
      std::string::npos)
      << table.err;
  const std::string back = "\n[[waypoint]]\naltitude_m = 1\nstay_s = 8\n";
  EXPECT_EQ(messages(there + back, {}).find(said), std::string::npos);
}

TEST(EnduranceCommand, SaysThatTheAirIsTooFast) {
  const auto folder = TestFolder();
  const auto fast = RunLipoid(folder,
                              {"endurance",
                               "--vehicle",
                               "f450",
                               "--cell",
                               kCell,
                               "--series",
                               "4",
                               "--airspeed-m-per-s",
                               "60"});
  EXPECT_EQ(fast.exit_code, 1);
  EXPECT_NE(fast.out.find("or fly slower (--airspeed-m-per-s;"), std::string::npos) << fast.out;
}

TEST(EnduranceCommand, SaysWhichPowerThePackCannotGive) {
  const auto folder = TestFolder();
  WriteText(folder + "/peak.csv", "time_s,power_W\n0,0\n0.05,500\n60,3\n");
  const auto peak = RunLipoid(folder,
                              {"endurance",
                               "--cell",
                               kCell,
                               "--mission",
                               "power=peak.csv",
                               "--once",
                               "--summary",
                               "s.json"});
  EXPECT_EQ(peak.exit_code, 0) << peak.err;
  const auto summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary.at("ended_by"), "mission-done");
  EXPECT_EQ(summary.at("power_lack").at("since_s"), 0.0);
  EXPECT_EQ(summary.at("power_lack").at("power_W"), 500.0);
  EXPECT_NEAR(summary.at("power_lack").at("total_s").get<double>(), 0.05, 1e-12);
  EXPECT_NE(peak.out.find("The pack cannot give the 500 W that the mission takes at 0 s"),
            std::string::npos)
      << peak.out;
  // A pack that cannot start has no voltage and no current of a flight.
  WriteText(folder + "/never.csv", "time_s,power_W\n0,0\n60,500\n");
  const auto cannot = RunLipoid(
      folder,
      {"endurance", "--cell", kCell, "--mission", "power=never.csv", "--summary", "s.json"});
  EXPECT_EQ(cannot.exit_code, 1) << cannot.err;
  const auto never = ReadJson(folder, "s.json");
  EXPECT_EQ(never.at("ended_by"), "power");
  for (const char* key : {"minimum_voltage_V", "peak_current_A"})
    EXPECT_TRUE(never.at(key).is_null()) << key;
  WriteText(folder + "/long.csv", "time_s,power_W\n0,0\n10,3\n20,500\n");
  const auto ends = RunLipoid(
      folder, {"endurance", "--cell", kCell, "--mission", "power=long.csv", "--summary", "s.json"});
  EXPECT_EQ(ReadJson(folder, "s.json").at("ended_by"), "power");
  EXPECT_NE(ends.out.find("The pack cannot give the 500 W that the mission takes at 10 s"),
            std::string::npos)
      << ends.out;
}

TEST(EnduranceCommand, TablesTakePercent) {
  const auto folder = TestFolder();
  const auto rows =
      SummaryOf(folder,
                {"--vehicle", "mambo-physical", "--cell", kCell, "--over", "reserve=0%:10%:30%"})
          .at("over")
          .at("rows");
  ASSERT_EQ(rows.size(), 4U);
  EXPECT_DOUBLE_EQ(rows[1].at("value").get<double>(), 0.1);
  EXPECT_DOUBLE_EQ(rows[3].at("value").get<double>(), 0.3);
}

// Flights alone show v_oc only as far as they were flown.
TEST(EnduranceCommand, SaysWhereNoLogHasShownTheVoltage) {
  const auto folder = TestFolder();
  WriteFlownCell(folder, {0.6, 1.0}, {4.0, 4.15});
  const std::vector<std::string> words{"--vehicle", "mambo-physical", "--cell", "flown.json"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    return SummaryOf(folder, more).at("messages").dump();
  };
  const std::string said = "v_oc of flown is known between 0.6 and 1 of the charge";
  EXPECT_NE(with({}).find(said), std::string::npos);
  EXPECT_EQ(with({"--reserve", "65%"}).find(said), std::string::npos);
  // A row of a table as well as the estimate.
  EXPECT_NE(with({"--reserve", "65%", "--over", "reserve=20%:45%:65%"}).find(said),
            std::string::npos);
}

// Half of the payloads drawn are less than none.
TEST(EnduranceCommand, SaysThatManyDrawsLieBeyondTheirRange) {
  const auto folder = TestFolder();
  const auto said = [&](const std::string& payload) {
    const auto run = RunLipoid(folder,
                               {"endurance",
                                "--cell",
                                kCell,
                                "--vehicle",
                                "mambo-physical",
                                "--payload-g",
                                payload,
                                "--ensemble",
                                "20"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.err.find("50 % of the values of payload-g drawn lie beyond 0 to ") !=
           std::string::npos;
  };
  EXPECT_TRUE(said("0+-2"));
  EXPECT_FALSE(said("5+-2"));
}

TEST(EnduranceCommand, SaysWhatIsWrong) {
  const auto folder = TestFolder();
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"endurance", "--cell", kCell},
       "option --vehicle: expected a vehicle that is to fly, found none"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--over", "payload"},
       "option --over: expected NAME=FIRST:STEP:LAST, such as payload-g=0:100:500, found 'payload'"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--over", "load=0:1:2"},
       "quantity"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--mission", "glide"},
       "option --mission: expected hover, cruise, waypoints=FILE or power=FILE, found 'glide'"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--once"},
       "option --once is for missions of a file; level flight has no end"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--gains", "none.json"},
       "option --gains: it is for --mission waypoints=FILE"},
      {{"endurance",
        "--cell",
        kCell,
        "--mission",
        "power=p.csv",
        "--set",
        "air.air_density_kg_per_m3=1"},
       "options --set air.*: they are for --mission hover and cruise"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--battery", "1"},
       "option --battery: it says how a log is read, and only --mission power=FILE reads one"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--health", "two"},
       "option --health: expected a number, 0.01 .. 2, found 'two'"},
      {{"endurance",
        "--cell",
        kCell,
        "--vehicle",
        "mambo-physical",
        "--airspeed-m-per-s",
        "best-range"},
       "option --airspeed-m-per-s: best-range is for --mission cruise"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--reserve", "120%"}, "120"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--ensemble", "1"},
       "ensemble: expected at least 2 flights, or 0 for no intervals, found 1"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--set", "step_s=1e-300"},
       "step_s: expected 0 or a step of at least 0.0001 s, found 1e-300"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--mission", "waypoints="},
       "option --mission: expected waypoints=FILE, found no file"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--mission", "power=p.csv"},
       "option --vehicle: a mission of powers does not ask what takes them; leave it out"},
      {{"endurance", "--cell", kCell, "--vehicle", "mambo-physical", "--initial-soc", "1.5"},
       "the cell is beyond full at a state of charge of 1.5: no charger leaves it so"},
  };
  for (const auto& [arguments, message] : cases) {
    const auto run = RunLipoid(folder, arguments);
    EXPECT_EQ(run.exit_code, 2) << message;
    EXPECT_NE(run.err.find(message), std::string::npos) << run.err;
  }
  WriteText(folder + "/short.csv", "time_s,power_W\n0,5\n");
  const auto bad =
      RunLipoid(folder, {"endurance", "--cell", kCell, "--mission", "power=short.csv"});
  EXPECT_EQ(bad.exit_code, 3);
  EXPECT_NE(bad.err.find("expected a power over time of at least 2 rows, found 1"),
            std::string::npos)
      << bad.err;
}

}  // namespace
}  // namespace lipoid::test
