// A battery of an autopilot's log as a Log: which rows stay, and what is refused in which words.
#include "identify/logs/flight/flight_log.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "identify/logs/flight/updates.h"
#include "identify/logs/log.h"
#include "model/core/errors.h"
#include "tests/support/paths.h"

namespace lipoid {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

const AutopilotFormat& Ulog() { return AutopilotFormats()[1]; }

BatteryTrack Track(int number = 1) {
  return {.number = number,
          .message = "battery_status",
          .time_s = {10.0, 11.0, 12.0, 13.0},
          .voltage_V = {12.6, 12.0, 11.9, 12.4},
          .current_A = {0.5, 10.0, 11.0, 0.5},
          .temperature_degC = {20.0, 21.0, 22.0, 22.0},
          .cells = 3,
          .capacity_Ah = 1.5};
}

AutopilotLog LogOf(std::vector<BatteryTrack> tracks) {
  AutopilotLog log;
  log.vehicle = "PX4 1.16.0";
  log.batteries = std::move(tracks);
  return log;
}

Log Made(AutopilotLog log, const ReadOptions& options = {}) {
  return FlightLog("f.ulg", Ulog(), std::move(log), options);
}

std::string Refusal(AutopilotLog log, const ReadOptions& options = {}) {
  try {
    (void)Made(std::move(log), options);
  } catch (const LoadError& error) {
    return error.what();
  }
  return "not refused";
}

TEST(FlightLog, IsARecordWithDischargePositive) {
  const Log log = Made(LogOf({Track()}));
  EXPECT_EQ(log.record.time_s, Track().time_s);
  EXPECT_EQ(log.record.current_A, Track().current_A);
  EXPECT_EQ(log.record.voltage_V, Track().voltage_V);
  EXPECT_EQ(log.record.temperature_degC, Track().temperature_degC);
  EXPECT_EQ(log.report.format, "px4-ulog");
  EXPECT_EQ(log.report.current_sign, "discharge-positive");
  ASSERT_TRUE(log.report.flight);
  EXPECT_EQ(log.report.flight->cells, 3);
  EXPECT_EQ(log.report.flight->battery, 1);
  EXPECT_EQ(log.report.flight->vehicle, "PX4 1.16.0");
}

TEST(FlightLog, DropsAndCountsWhatTheAutopilotDidNotKnow) {
  BatteryTrack track = Track();
  track.current_A[1] = kUnknown;
  track.voltage_V[3] = 0.0;
  track.temperature_degC.assign(4, 0.0);  // no thermometer
  const Log log = Made(LogOf({track}));
  EXPECT_EQ(log.record.time_s, (std::vector<double>{10.0, 12.0}));
  EXPECT_EQ(log.report.dropped_unknown, 2U);
  EXPECT_EQ(log.report.dropped_rows(), 2U);
  EXPECT_TRUE(log.record.temperature_degC.empty());
}

TEST(FlightLog, ADamagedTimeCostsItsRowAlone) {
  for (const double damaged_s : {1e12, -5.0, 10.0}) {
    BatteryTrack track = Track();
    track.time_s[2] = damaged_s;
    const Log log = Made(LogOf({track}));
    EXPECT_EQ(log.record.time_s, (std::vector<double>{10.0, 11.0, 13.0})) << damaged_s;
    EXPECT_EQ(log.report.dropped_repeated_times, 1U);
  }
}

TEST(FlightLog, ASingleChargeBeyondAllThatThePackGivesIsDamage) {
  const auto rows_of = [](const std::vector<double>& current_A) {
    BatteryTrack track = Track();
    track.time_s.clear();
    for (std::size_t k = 0; k < current_A.size(); ++k) track.time_s.push_back(10.0 + double(k));
    track.current_A = current_A;
    track.voltage_V.assign(current_A.size(), 12.0);
    track.voltage_V[1] = 11.8;
    track.temperature_degC.assign(current_A.size(), 20.0);
    return Made(LogOf({track}));
  };
  const Log log = rows_of({0.5, 10.0, -322.0, 11.0, 12.0, 10.0});
  EXPECT_EQ(log.record.current_A, (std::vector<double>{0.5, 10.0, 11.0, 12.0, 10.0}));
  EXPECT_EQ(log.report.dropped_unknown, 1U);
  ASSERT_EQ(log.report.warnings.size(), 1U);
  EXPECT_EQ(log.report.warnings[0],
            "1 row dropped: a current of -322 A at 12 s, with which the pack would be charged by "
            "more than it ever gives; a damaged message may hold it");
  EXPECT_EQ(rows_of({-90.0, 10.0, 50.0, 20.0, -80.0}).report.dropped_unknown, 2U);
  // Motors that brake, a pack that is charged for longer, and a sensor that is the other way round.
  EXPECT_EQ(rows_of({0.5, 10.0, -9.0, 11.0, 12.0}).report.dropped_unknown, 0U);
  EXPECT_EQ(rows_of({0.5, 10.0, -30.0, -31.0, 12.0}).report.dropped_unknown, 0U);
  EXPECT_EQ(rows_of({-0.5, -10.0, -5.0, -12.0, -6.0}).report.dropped_unknown, 0U);
}

// 12.6 V less 20 mOhm times the current. A current that flows moves the voltage, in its row or in the next.
TEST(FlightLog, ASingleCurrentFarBeyondAllOthersThatNoVoltageShowsIsDamage) {
  const auto rows_of = [](const std::vector<double>& current_A,
                          const std::vector<double>& flows_A) {
    BatteryTrack track = Track();
    track.time_s.clear();
    track.voltage_V.clear();
    for (std::size_t k = 0; k < current_A.size(); ++k) {
      track.time_s.push_back(10.0 + static_cast<double>(k));
      track.voltage_V.push_back(12.6 - 0.02 * flows_A[k]);
    }
    track.current_A = current_A;
    track.temperature_degC.assign(current_A.size(), 20.0);
    return Made(LogOf({track}));
  };
  std::vector<double> flows{0.5, 10.0, 11.0, 27.0, 12.0, 10.0, 9.0, 11.0};
  for (int k = 0; k < 24; ++k) flows.push_back(k % 3 == 0 ? 3.0 : 12.0);
  std::vector<double> damaged = flows;
  damaged[2] = 262.0;
  damaged[4] = 223.0;
  damaged[6] = -218.0;
  const Log log = rows_of(damaged, flows);
  std::vector<double> kept = flows;
  for (const int row : {6, 4, 2}) kept.erase(kept.begin() + row);
  EXPECT_EQ(log.record.current_A, kept);
  EXPECT_EQ(log.report.dropped_unknown, 3U);
  ASSERT_EQ(log.report.warnings.size(), 2U);
  EXPECT_EQ(
      log.report.warnings[0],
      "2 rows dropped: a current of 262 A at 12 s, the first of them, which no other row comes near, "
      "and of which the voltage shows nothing; a damaged message may hold it");
  // A jump that the voltage shows, at once or a row later, is one, and so is one of twice the rest.
  for (const int later : {0, 1}) {
    std::vector<double> shown = flows;
    shown[static_cast<std::size_t>(2 + later)] = 262.0;
    EXPECT_EQ(rows_of(damaged, shown).report.dropped_unknown, 1U) << later;  // the one of 223 A
  }
  damaged = flows;
  damaged[2] = 60.0;
  EXPECT_EQ(rows_of(damaged, flows).report.dropped_unknown, 0U);
}

TEST(FlightLog, TakesAPartFromZeroOn) {
  ReadOptions options;
  options.start_s = 11.0;
  options.end_s = 12.5;
  const Log log = Made(LogOf({Track()}), options);
  EXPECT_EQ(log.record.time_s, (std::vector<double>{0.0, 1.0}));
  EXPECT_EQ(log.report.dropped_unselected, 2U);
}

TEST(FlightLog, TakesTheBatteryThatIsAskedFor) {
  ReadOptions options;
  options.battery = 2;
  BatteryTrack second = Track(2);
  second.voltage_V = {25.0, 24.0, 24.0, 25.0};
  EXPECT_EQ(Made(LogOf({Track(), second}), options).record.voltage_V, second.voltage_V);
  // One that was announced and never logged needs no choice.
  BatteryTrack empty;
  empty.number = 2;
  EXPECT_EQ(Made(LogOf({Track(), empty})).report.flight->battery, 1);
}

TEST(FlightLog, RefusesWithTheReason) {
  EXPECT_EQ(Refusal(LogOf({})),
            "f.ulg:1:1: error: expected a battery in this px4-ulog log, found no message "
            "battery_status; the autopilot did not log one");
  BatteryTrack empty;
  EXPECT_EQ(Refusal(LogOf({empty})),
            "f.ulg:1:1: error: expected rows of a battery, found battery 1 (0 rows)");
  EXPECT_EQ(Refusal(LogOf({Track(1), Track(2)})),
            "f.ulg:1:1: error: expected one battery, found battery 1 (4 rows, 11.9 V to 12.6 V), "
            "battery 2 (4 rows, 11.9 V to 12.6 V); say which with `battery` (--battery 1)");
  EXPECT_EQ(Refusal(LogOf({Track(1), Track(1)})),
            "f.ulg:1:1: error: expected one log, found battery 1 (4 rows, 11.9 V to 12.6 V), battery 1 (4 rows, "
            "11.9 V to 12.6 V): two logs were joined here; save each as a file of its own");
  ReadOptions third;
  third.battery = 3;
  EXPECT_EQ(
      Refusal(LogOf({Track()}), third),
      "f.ulg:1:1: error: expected rows of battery 3 as the option battery says, found battery "
      "1 (4 rows, 11.9 V to 12.6 V)");
  BatteryTrack track = Track();
  track.current_A.assign(4, kUnknown);
  EXPECT_EQ(Refusal(LogOf({track})),
            "f.ulg:1:1: error: expected a current, found none in the 4 rows of battery 1: the "
            "autopilot had no current sensor");
  track = Track();
  track.voltage_V.assign(4, 0.0);
  EXPECT_EQ(Refusal(LogOf({track})),
            "f.ulg:1:1: error: expected the voltage of a battery, found none in the 4 rows of "
            "battery 1: none was connected, or its voltage was not measured");
  track.voltage_V.assign(4, 0.4);
  EXPECT_EQ(Refusal(LogOf({track})),
            "f.ulg:1:1: error: expected the voltage of a battery, found at most 0.4 V: none was "
            "connected, or its voltage was not measured");
  track.voltage_V.assign(4, 12.15);
  EXPECT_EQ(Refusal(LogOf({track})),
            "f.ulg:1:1: error: expected a voltage that falls under load, found 12.15 V throughout "
            "while the current goes from 0.5 A to 11 A, as in a simulation");
  ReadOptions late;
  late.start_s = 100.0;
  EXPECT_EQ(Refusal(LogOf({Track()}), late),
            "f.ulg:1:1: error: expected rows within start_s and end_s as given, found none "
            "(times of the log: 10 to 13 s)");
  ReadOptions columns;
  columns.columns = {{"time_s", "t"}};
  EXPECT_EQ(Refusal(LogOf({Track()}), columns),
            "f.ulg:1:1: error: expected a table because of the options steps, cycles, columns or "
            "units, found a px4-ulog log, which names its own; leave them out");
  ReadOptions sign;
  sign.current_sign = "discharge-negative";
  EXPECT_EQ(Refusal(LogOf({Track()}), sign),
            "f.ulg:1:1: error: expected discharge to be negative because of current_sign, found a "
            "px4-ulog log, in which it is positive by definition; leave the option out");
}

TEST(FlightLog, AnIdlePackIsNoSimulation) {
  BatteryTrack track = Track();
  track.voltage_V.assign(4, 12.15);
  track.current_A = {0.1, 0.1, 0.2, 0.1};
  EXPECT_EQ(Made(LogOf({track})).record.size(), 4U);
}

TEST(FlightLog, SaysHowOftenItsValuesReallyChange) {
  BatteryTrack track = Track();
  track = BatteryTrack();
  for (int k = 0; k < 80; ++k) {
    track.time_s.push_back(0.1 * k);
    track.voltage_V.push_back(12.0 - 0.01 * (k / 8));
    track.current_A.push_back(5.0 + k / 2 % 3);
    track.temperature_degC.push_back(kUnknown);
  }
  const Log log = Made(LogOf({track}));
  EXPECT_NEAR(log.report.flight->voltage_update_s, 0.8, 1e-9);
  EXPECT_NEAR(log.report.flight->current_update_s, 0.2, 1e-9);
  ASSERT_EQ(log.report.notes.size(), 1U);
  EXPECT_EQ(log.report.notes[0],
            "rows come each 0.1 s, but the voltage changes each 0.8 s and the current each 0.2 s: "
            "values are repeated until new ones come");
}

TEST(ReadLog, ReadsFlightsAndRefusesABatteryOfATable) {
  ReadOptions options;
  options.battery = 2;
  const Log log = ReadLog(test::SourcePath("fixtures/flights/sample_log_small.ulg"), options);
  EXPECT_EQ(log.record.size(), 21U);
  EXPECT_GT(log.record.voltage_V[0], 49.0);
  EXPECT_EQ(log.report.notes.size(), 1U);  // the dropout
  try {
    (void)ReadLog(test::SourcePath("fixtures/flights/log171.csv"), options);
    FAIL();
  } catch (const LoadError& error) {
    EXPECT_NE(std::string(error.what())
                  .find("expected a flight log because of the option battery, found a table"),
              std::string::npos);
  }
}

// The gap of 2.1 s, the staircase of a smart battery that reports its voltage each 0.8 s.
TEST(ReadLog, FindsWhatTheSoloDoes) {
  const Log log = ReadLog(test::SourcePath("fixtures/flights/log171.bin"));
  EXPECT_EQ(log.report.rows, 2384U);
  ASSERT_EQ(log.report.gaps.size(), 1U);
  EXPECT_NEAR(log.report.gaps[0].length_s, 2.1, 0.01);
  EXPECT_NEAR(log.report.flight->voltage_update_s, 0.8, 0.05);
  EXPECT_NEAR(log.report.flight->current_update_s, 0.2, 0.05);
  const double charge_mAh = DeliveredCharge(log.record).back() / 3.6;
  EXPECT_NEAR(charge_mAh, 729.0, 5.0);  // README of the source: trapezoids, not steps
}

}  // namespace
}  // namespace lipoid
