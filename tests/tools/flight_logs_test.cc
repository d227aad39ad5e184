// FlightFixture logs and tables without a header, through the command line.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "identify/logs/log.h"
#include "model/core/json.h"
#include "tests/support/paths.h"
#include "tests/support/run_lipoid.h"
#include "tests/support/text_files.h"

namespace lipoid::test {
namespace {

TEST(InspectFlights, SaysVehicleBatteryAndUpdates) {
  const std::string summary = ScratchPath("inspect_flight.json");
  const auto run =
      RunLipoid(TestFolder(), {"inspect", FlightFixture("log171.bin"), "--summary", summary});
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find("vehicle      APM:Copter V3.3-dev (ae3192b8), frame QUAD"),
            std::string::npos)
      << run.out;
  EXPECT_NE(run.out.find("5.2 Ah as the autopilot was told"), std::string::npos);
  const Json file = ParseJson(ReadTextFile(summary), summary).at("files").at(0);
  EXPECT_EQ(file.at("rows"), 2384);
  EXPECT_EQ(file.at("suggested_kind"), nullptr);
  EXPECT_EQ(file.at("flight").at("batteries"), Json::array({1}));
  EXPECT_NEAR(file.at("flight").at("voltage_update_s").get<double>(), 0.8, 0.05);
}

TEST(InspectFlights, AsksWhichBattery) {
  const auto open = RunLipoid(TestFolder(), {"inspect", FlightFixture("sample_log_small.ulg")});
  EXPECT_EQ(open.exit_code, 3);
  EXPECT_NE(open.err.find("say which with `battery` (--battery 1)"), std::string::npos) << open.err;
  const auto second =
      RunLipoid(TestFolder(), {"inspect", FlightFixture("sample_log_small.ulg"), "--battery", "2"});
  EXPECT_EQ(second.exit_code, 0) << second.err;
  EXPECT_NE(second.out.find("2 of 2; 12 cells in series, 6 Ah as the autopilot was told"),
            std::string::npos)
      << second.out;
}

TEST(ConvertFlights, WritesTheRowsThatWereRead) {
  const std::string csv = ScratchPath("flight.csv");
  const auto run =
      RunLipoid(TestFolder(), {"convert", FlightFixture("esc_status_log.ulg"), "-o", csv});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const Log first = ReadLog(FlightFixture("esc_status_log.ulg"));
  ReadOptions positive;  // a flight without a rest settles no sign by itself
  positive.current_sign = "discharge-positive";
  const Log again = ReadLog(csv, positive);
  EXPECT_EQ(again.record.time_s, first.record.time_s);
  EXPECT_EQ(again.record.current_A, first.record.current_A);
  EXPECT_EQ(again.record.voltage_V, first.record.voltage_V);
}

TEST(ConvertFlights, WithoutABatteryIsBadInput) {
  const std::string bytes = ReadTextFile(FlightFixture("esc_status_log.ulg"));
  const std::string file = WriteText("no_battery.ulg", bytes.substr(0, 1000));
  const std::string csv = ScratchPath("no_battery.csv");
  const auto run = RunLipoid(TestFolder(), {"convert", file, "-o", csv});
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_NE(
      run.err.find("expected a battery in this px4-ulog log, found no message battery_status"),
      std::string::npos)
      << run.err;
}

TEST(Columns, ByTheirNumbersForATableWithoutHeader) {
  const std::string table = ReadTextFile(FlightFixture("log171.csv"));
  const std::string rows = table.substr(table.find('\n') + 1);
  const std::string file = WriteText("no_header.csv", rows);
  const std::string csv = ScratchPath("no_header_out.csv");
  const auto run = RunLipoid(TestFolder(),
                             {"convert",
                              file,
                              "--columns",
                              "time_s=2",
                              "voltage_V=3",
                              "current_A=4",
                              "--units",
                              "s,A,V",
                              "--current-sign",
                              "discharge-positive",  // a staircase settles no sign by itself
                              "-o",
                              csv});
  ASSERT_EQ(run.exit_code, 0) << run.err;
  ReadOptions positive;
  positive.current_sign = "discharge-positive";
  const Log named = ReadLog(FlightFixture("log171.csv"), positive);
  EXPECT_EQ(ReadLog(csv, positive).record.voltage_V, named.record.voltage_V);
  EXPECT_EQ(ReadLog(csv, positive).record.current_A, named.record.current_A);

  const auto unit = RunLipoid(
      TestFolder(),
      {"convert", file, "--columns", "time_s=2", "voltage_V=3", "current_A=4", "-o", csv});
  EXPECT_EQ(unit.exit_code, 3);
  EXPECT_NE(unit.err.find("expected a header that states the unit of the time"), std::string::npos)
      << unit.err;
  const auto none = RunLipoid(TestFolder(),
                              {"convert",
                               file,
                               "--columns",
                               "time_s=2",
                               "voltage_V=3",
                               "current_A=9",
                               "--units",
                               "s,A,V",
                               "-o",
                               csv});
  EXPECT_EQ(none.exit_code, 3);
  EXPECT_NE(none.err.find("expected a column '9' as the option columns says, found 1, 2, 3, 4"),
            std::string::npos)
      << none.err;
}

}  // namespace
}  // namespace lipoid::test
