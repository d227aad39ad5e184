// The program as a user meets it: help at every level, streams that close, outputs that cannot be.
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/run_lipoid.h"

namespace lipoid::test {
namespace {

// The names in the list of commands of `lipoid --help`.
std::vector<std::string> Commands(const std::string& help) {
  std::vector<std::string> names;
  std::istringstream lines(help.substr(help.find("Commands:\n") + 10));
  for (std::string line; std::getline(lines, line) && !line.empty();) {
    names.push_back(line.substr(2, line.find(' ', 2) - 2));
  }
  return names;
}

TEST(Program, SaysItsVersion) {
  const auto run = RunLipoid(TestFolder(), {"--version"});
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out.substr(0, 9), "lipoid 0.");
}

TEST(Program, HelpAtEveryLevelHasAnExampleThatBeginsWithTheCommand) {
  const auto folder = TestFolder();
  const auto top = RunLipoid(folder, {"--help"});
  EXPECT_EQ(top.exit_code, 0);
  EXPECT_NE(top.out.find("Example:\n  lipoid "), std::string::npos);
  const auto commands = Commands(top.out);
  EXPECT_GE(commands.size(), 2U);
  for (const auto& command : commands) {
    SCOPED_TRACE(command);
    const auto run = RunLipoid(folder, {command, "--help"});
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_EQ(run.err, "");
    EXPECT_NE(run.out.find("Usage: lipoid " + command), std::string::npos) << run.out;
    const auto example = run.out.find("Example");
    ASSERT_NE(example, std::string::npos) << run.out;
    EXPECT_NE(run.out.find("\n  lipoid " + command + " ", example), std::string::npos) << run.out;
    for (const char* common : {"--summary", "--seed", "--threads", "--quiet", "--set", "--help"}) {
      EXPECT_NE(run.out.find(common), std::string::npos) << common;
    }
    EXPECT_EQ(RunLipoid(folder, {"help", command}).out, run.out);
  }
  EXPECT_TRUE(FilesIn(folder).empty());
}

TEST(Program, AReaderWhoLeavesEarlyIsNoError) {
  const auto folder = TestFolder();
  // The reader is gone before lipoid writes its first byte.
  const auto run = RunShell(folder, "{ sleep 0.3; \"$LIPOID\" list cells; echo $? >code; } | true");
  EXPECT_EQ(ReadTextFile(folder + "/code"), "0\n");
  EXPECT_EQ(run.err, "");
}

TEST(Program, AFullDiskIsSaid) {
  const auto run = RunShell(TestFolder(), "\"$LIPOID\" list cells >/dev/full");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err,
            "lipoid list: error: cannot write to standard output: No space left on device\n"
            "Try 'lipoid list --help'.\n");
}

TEST(Program, StandardOutputThatIsAFileIsNotReplaced) {
  const auto folder = TestFolder();
  const auto run =
      RunShell(folder, "echo first >all; \"$LIPOID\" list cells --summary - >>all 2>said");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto all = ReadTextFile(folder + "/all");
  EXPECT_EQ(all.substr(0, 6), "first\n");
  EXPECT_NE(ReadTextFile(folder + "/said").find("gifi-600mAh-1 "), std::string::npos);
  EXPECT_NE(all.find("\"command\": \"list\""), std::string::npos);
}

TEST(Program, ColourAndProgressAreForTerminals) {
  const auto run = RunLipoid(TestFolder(), {"lst"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_EQ(run.err.find('\033'), std::string::npos);
}

TEST(Program, ListsTheShippedCells) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"list", "cells", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 0);
  std::vector<std::string> names;
  const auto summary = ReadJson(folder, "s.json");
  for (const auto& cell : summary.at("cells")) names.push_back(cell.at("name"));
  EXPECT_EQ(names,
            (std::vector<std::string>{"gifi-600mAh-1",
                                      "gifi-600mAh-2",
                                      "gifi-600mAh-3",
                                      "grepow-32Ah-1",
                                      "grepow-32Ah-2",
                                      "grepow-32Ah-3"}));
  for (const auto& name : names) EXPECT_NE(run.out.find(name), std::string::npos);
}

// At hover the thrusts hold the weight, the motor's torque is its friction and drag, and the
// voltage is what falls over winding and rotor.
TEST(Program, ListsTheShippedVehiclesWithTheirHover) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"list", "vehicles", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 0);
  const auto summary = ReadJson(folder, "s.json");
  const auto& rows = summary.at("vehicles");
  ASSERT_EQ(rows.size(), ShippedVehicleNames().size());
  constexpr double kRounding = 1e-12;
  for (const auto& row : rows) {
    const Vehicle v = LoadVehicle(row.at("name"));
    SCOPED_TRACE(v.name);
    EXPECT_NE(run.out.find(v.name), std::string::npos);
    EXPECT_NE(run.out.find(v.summary.substr(0, 25)), std::string::npos) << "it may wrap later";
    const double speed = row.at("hover_speed_rad_per_s");
    const double current = row.at("hover_motor_current_A");
    const double voltage = row.at("hover_motor_voltage_V");
    const double rotors = double(v.rotor_count());  // none of them coaxial
    EXPECT_NEAR(
        rotors * v.thrust_coefficient_N_s2 * speed * speed / (v.mass_kg * 9.81), 1.0, kRounding);
    EXPECT_NEAR(v.motor_constant_N_m_per_A * current /
                    (v.friction_N_m_s * speed + v.torque_coefficient_N_m_s2 * speed * speed),
                1.0,
                kRounding);
    EXPECT_NEAR(v.armature_resistance_Ohm * current + v.motor_constant_N_m_per_A * speed,
                voltage,
                kRounding);
    EXPECT_NEAR(row.at("hover_duty").get<double>() * v.nominal_voltage_V, voltage, kRounding);
  }
}

TEST(Program, ListsTheShippedGains) {
  const auto folder = TestFolder();
  const auto run = RunLipoid(folder, {"list", "gains", "--summary", "s.json"});
  EXPECT_EQ(run.exit_code, 0);
  const auto summary = ReadJson(folder, "s.json");
  const auto& rows = summary.at("gains");
  ASSERT_EQ(rows.size(), 2U);
  EXPECT_EQ(rows[0].at("name"), "aware");
  EXPECT_EQ(rows[0].at("altitude").at("derivative"), 7.87);
  EXPECT_EQ(rows[1].at("name"), "unaware");
  EXPECT_EQ(rows[1].at("attitude").at("derivative"), 0.12);
  for (const char* const text : {"7.87", "5.03", "1.36", "0.54", "position", "aware", "unaware"}) {
    EXPECT_NE(run.out.find(text), std::string::npos) << text;
  }
}

}  // namespace
}  // namespace lipoid::test
