// lipoid vehicle, end to end. The numbers themselves: tests/identify/vehicle/.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

std::vector<std::string> Body(std::vector<std::string> more) {
  std::vector<std::string> words{"vehicle",
                                 "--mass-g",
                                 "1600",
                                 "--frame-mm",
                                 "450",
                                 "--series",
                                 "4",
                                 "--propeller-in",
                                 "9.4",
                                 "-o",
                                 "mine.toml"};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

std::string Bench() { return SourcePath("fixtures/bench/readytosky-2312-920kv_dji-9450.csv"); }

TEST(VehicleCommand, WritesAFileThatFlies) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder,
                             Body({"--pitch-in",
                                   "5",
                                   "--kv-rpm-per-V",
                                   "920",
                                   "--winding-resistance-Ohm",
                                   "0.12",
                                   "--no-load-A",
                                   "0.5",
                                   "--avionics-W",
                                   "5",
                                   "--summary",
                                   "s.json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Vehicle v = LoadVehicle(folder + "/mine.toml");
  EXPECT_EQ(v.name, "mine");
  EXPECT_EQ(v.avionics_power_W, 5.0);
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_EQ(summary["sources"]["mass_kg"], "given: 1600 g");
  EXPECT_GT(summary["thrust_to_weight"], 1.0);
  EXPECT_TRUE(summary["bench"].is_null());
  EXPECT_NE(run.err.find("assumed: inertia_kg_m2"), std::string::npos) << run.err;
  EXPECT_NE(run.out.find("largest thrust over weight"), std::string::npos) << run.out;
  const auto flight = RunLipoid(
      folder, {"fly", "hover", "--battery", "ideal", "--vehicle", "mine.toml", "--duration", "1"});
  EXPECT_EQ(flight.exit_code, 0) << flight.err;
}

TEST(VehicleCommand, FitsABenchTable) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(
      folder, Body({"--bench-table", Bench(), "--kv-rpm-per-V", "920", "--summary", "s.json"}));
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Json summary = ReadJson(folder, "s.json");
  EXPECT_TRUE(summary["bench"]["converged"]);
  EXPECT_LT(summary["bench"]["thrust_rms_percent"], 5.0);
  ASSERT_EQ(summary["cautions"].size(), 1U);
  EXPECT_NE(run.err.find("the duty cycle is the throttle to the power of 0.9"), std::string::npos)
      << run.err;
  for (const Json& parameter : summary["bench"]["parameters"]) {
    if (!parameter["fitted"] || parameter["standard_error"].is_null()) continue;
    EXPECT_LE(parameter["interval_95"][0], parameter["estimate"]) << parameter;
    EXPECT_GE(parameter["interval_95"][1], parameter["estimate"]) << parameter;
  }
}

// Of a motor of 920 rpm/V with a propeller whose figure of merit is 0.65.
TEST(VehicleCommand, DoubtsTheCurrentOfAllMotors) {
  const auto folder = TestFolder();
  const auto cautions = [&](double motors) {
    std::ofstream table(folder + "/t.csv");
    table << "Throttle (%),Thrust (g),RPM,Voltage (V),Current (A)\n";
    constexpr double kRows[][5] = {{30, 264.0, 4077, 16.674, 1.318},
                                   {40, 439.8, 5261, 16.642, 2.887},
                                   {50, 645.9, 6376, 16.595, 5.256},
                                   {60, 876.6, 7428, 16.530, 8.511},
                                   {70, 1126.4, 8420, 16.446, 12.707},
                                   {80, 1390.6, 9356, 16.343, 17.874},
                                   {90, 1665.1, 10238, 16.220, 24.021},
                                   {100, 1946.0, 11068, 16.077, 31.133}};
    for (const auto& row : kRows) {
      table << row[0] << ',' << row[1] << ',' << row[2] << ',' << row[3] << ',' << motors * row[4]
            << '\n';
    }
    table.close();
    const auto run = RunLipoid(
        folder, Body({"--bench-table", "t.csv", "--kv-rpm-per-V", "920", "--summary", "s.json"}));
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return ReadJson(folder, "s.json").at("cautions").dump();
  };
  const std::string said = "in another unit, or the current of all motors?";
  EXPECT_EQ(cautions(1.0).find(said), std::string::npos);
  EXPECT_NE(cautions(4.0).find(said), std::string::npos);
  EXPECT_NE(cautions(1000.0).find(said), std::string::npos);
}

// docs/vehicles.md has the commands: the numbers of the files are what they give.
TEST(VehicleCommand, ShippedVehiclesAreThoseOfTheirCommands) {
  const auto folder = TestFolder();
  struct Shipped {
    std::string name;
    std::string table;
    std::vector<std::string> options;  // the values of those below
  };
  const std::vector<std::string> names{"--mass-g",
                                       "--frame-mm",
                                       "--series",
                                       "--propeller-in",
                                       "--avionics-W",
                                       "--kv-rpm-per-V",
                                       "--layout"};
  const std::vector<Shipped> all{{"f450",
                                  "readytosky-2312-920kv_dji-9450.csv",
                                  {"1600", "450", "4", "9.4", "5", "920", "quad-x"}},
                                 {"camera-10in",
                                  "tmotor-3110-780kv_multistar-1045.csv",
                                  {"1800", "460", "4", "10", "9", "780", "quad-x"}},
                                 {"hexacopter",
                                  "tarot-4114-320kv_tarot-1555.csv",
                                  {"5000", "960", "6", "15", "10", "320", "hexa-x"}}};
  for (const Shipped& one : all) {
    std::vector<std::string> words{"vehicle",
                                   "--name",
                                   one.name,
                                   "-o",
                                   one.name + ".toml",
                                   "--front-right-turns",
                                   "counter-clockwise",
                                   "--bench-table",
                                   SourcePath("fixtures/bench/" + one.table)};
    for (std::size_t k = 0; k < names.size(); ++k)
      words.insert(words.end(), {names[k], one.options[k]});
    const auto run = RunLipoid(folder, words);
    ASSERT_EQ(run.exit_code, 0) << run.err;
    const auto numbers = [](const Vehicle& v) {
      return std::vector<double>{v.mass_kg,
                                 v.inertia_kg_m2[0],
                                 v.inertia_kg_m2[2],
                                 v.thrust_coefficient_N_s2,
                                 v.torque_coefficient_N_m_s2,
                                 v.motor_constant_N_m_per_A,
                                 v.armature_resistance_Ohm,
                                 v.friction_N_m_s,
                                 v.rotor_inertia_kg_m2,
                                 v.avionics_power_W,
                                 v.linear_drag_N_s_per_m};
    };
    const auto shipped = numbers(LoadVehicle(one.name));
    const auto made = numbers(LoadVehicle(folder + "/" + one.name + ".toml"));
    // Files have five digits of what is fitted.
    for (std::size_t k = 0; k < shipped.size(); ++k)
      EXPECT_NEAR(made[k], shipped[k], 2e-5 * std::abs(shipped[k])) << one.name << " " << k;
  }
}

// Losses at part load are not friction, and a propeller of 5 inch has no figure of merit of 1.3.
TEST(VehicleCommand, TakesATableOfARacerAndItsCurrentWithoutLoad) {
  const auto folder = TestFolder();
  std::ofstream(folder + "/racer.csv")
      << "Throttle (%),Thrust (g),RPM,Voltage (V),Current (A)\n30,210,11600,16.6,3.2\n"
         "50,520,18100,16.4,10.5\n70,900,23500,16.0,22.5\n100,1500,29800,15.4,42\n";
  const auto merit = [&](std::vector<std::string> more) {
    std::vector<std::string> words{"vehicle",
                                   "--mass-g",
                                   "650",
                                   "--frame-mm",
                                   "220",
                                   "--series",
                                   "4",
                                   "--propeller-in",
                                   "5",
                                   "--bench-table",
                                   "racer.csv",
                                   "-o",
                                   "racer.toml"};
    words.insert(words.end(), more.begin(), more.end());
    const auto run = RunLipoid(folder, words);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    const Vehicle v = LoadVehicle(folder + "/racer.toml");
    // Thrust over speed squared of the rows: 1.40e-6 to 1.51e-6.
    EXPECT_GT(v.thrust_coefficient_N_s2, 1.39e-6);
    EXPECT_LT(v.thrust_coefficient_N_s2, 1.52e-6);
    const double area_m2 = 0.25 * 3.14159 * 0.127 * 0.127;
    return std::pow(v.thrust_coefficient_N_s2, 1.5) / std::sqrt(2.0 * 1.225 * area_m2) /
           v.torque_coefficient_N_m_s2;
  };
  const auto plausible = [](double value) { return value > 0.4 && value < 0.75; };
  EXPECT_PRED1(plausible, merit({"--kv-rpm-per-V", "2400"}));
  EXPECT_PRED1(plausible, merit({"--kv-rpm-per-V", "2400", "--no-load-A", "1.2"}));
  // 1.2 A at 10 V.
  EXPECT_NEAR(LoadVehicle(folder + "/racer.toml").friction_N_m_s,
              0.12 * std::pow(30.0 / 3.14159265 / 2400.0, 2),
              1e-10);
  // Such a table does not tell KV from the resistance, and says so.
  const auto without = RunLipoid(folder,
                                 {"vehicle",
                                  "--mass-g",
                                  "650",
                                  "--frame-mm",
                                  "220",
                                  "--series",
                                  "4",
                                  "--propeller-in",
                                  "5",
                                  "--bench-table",
                                  "racer.csv",
                                  "-o",
                                  "bare.toml"});
  EXPECT_EQ(without.exit_code, 2);
  EXPECT_NE(without.err.find("give the motor's with --kv-rpm-per-V"), std::string::npos)
      << without.err;
}

TEST(VehicleCommand, RefusalsSayWhatToGive) {
  const auto folder = TestFolder();
  const auto bare = RunLipoid(folder, {"vehicle", "--mass-g", "1000", "-o", "v.toml"});
  EXPECT_EQ(bare.exit_code, 2);
  EXPECT_NE(bare.err.find("no vehicle without --frame-mm, --series, --propeller-in: give them"),
            std::string::npos)
      << bare.err;
  const auto none = RunLipoid(folder, Body({"--kv-rpm-per-V", "0"}));
  EXPECT_EQ(none.exit_code, 2);
  // What no command would read is not written.
  const auto flat = RunLipoid(folder,
                              Body({"--bench-table",
                                    Bench(),
                                    "--kv-rpm-per-V",
                                    "920",
                                    "--inertia-kg-m2",
                                    "0.01",
                                    "0.01",
                                    "0.05"}));
  EXPECT_EQ(flat.exit_code, 2);
  EXPECT_NE(
      flat.err.find("these numbers make no vehicle: inertia_kg_m2: expected moments of a body"),
      std::string::npos)
      << flat.err;
  const auto slow = RunLipoid(folder,
                              Body({"--bench-table",
                                    Bench(),
                                    "--kv-rpm-per-V",
                                    "920",
                                    "--esc-switching-ns",
                                    "1000000",
                                    "--esc-pwm-kHz",
                                    "48"}));
  EXPECT_EQ(slow.exit_code, 2);
  EXPECT_NE(slow.err.find("expected at most half a period of esc_switching_frequency_Hz, found 48"),
            std::string::npos)
      << slow.err;
  const auto twice = RunLipoid(
      folder, Body({"--bench-table", Bench(), "--kv-rpm-per-V", "920", "--pitch-in", "5"}));
  EXPECT_EQ(twice.exit_code, 2);
  EXPECT_NE(twice.err.find("option --pitch-in: --bench-table says what the propeller does"),
            std::string::npos)
      << twice.err;
  const auto pitched = RunLipoid(folder,
                                 Body({"--kv-rpm-per-V",
                                       "920",
                                       "--winding-resistance-Ohm",
                                       "0.1",
                                       "--no-load-A",
                                       "0.5",
                                       "--thrust-coefficient",
                                       "0.1",
                                       "--power-coefficient",
                                       "0.04",
                                       "--blades",
                                       "3"}));
  EXPECT_EQ(pitched.exit_code, 2);
  EXPECT_NE(pitched.err.find("option --blades: --thrust-coefficient and --power-coefficient say"),
            std::string::npos)
      << pitched.err;
  const auto alone = RunLipoid(
      folder, Body({"--bench-table", Bench(), "--kv-rpm-per-V", "920", "--no-load-V", "12"}));
  EXPECT_EQ(alone.exit_code, 2);
  EXPECT_NE(
      alone.err.find("option --no-load-V: it is the voltage at which --no-load-A was measured"),
      std::string::npos)
      << alone.err;
  const auto missing = RunLipoid(folder, Body({"--bench-table", "no.csv"}));
  EXPECT_EQ(missing.exit_code, 3) << missing.err;
  EXPECT_TRUE(FilesIn(folder).empty());
}

}  // namespace
}  // namespace lipoid::test
