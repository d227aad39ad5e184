#include "identify/logs/discharge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "model/battery/cell.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/plain_csv.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::LoadErrorOf;
using test::RecordOfSteps;

// Gives every row the voltage of its time.
Record WithVoltage(Record record, const std::function<double(double)>& voltage_V) {
  for (std::size_t k = 0; k < record.size(); ++k) record.voltage_V[k] = voltage_V(record.time_s[k]);
  return record;
}

// Falls by 1 mV/s from the switch-on at 100 s and crosses 3 V 1000.25 s after it.
double Falling(double time_s) { return 3.0 + 0.001 * (1100.25 - std::max(time_s, 100.0)); }

TEST(IsBelowCutoff, OfAPackTheLastRowOfALogMayLieOnTheSteepEnd) {
  Cell cell;
  cell.cutoff_V = 3.0;
  cell.series = 2;
  constexpr std::size_t kRows = 10;
  EXPECT_FALSE(IsBelowCutoff(cell, 1.0, 6.0 - 1.9 * kCutoffTolerance_V, 4, kRows));
  EXPECT_TRUE(IsBelowCutoff(cell, 1.0, 6.0 - 2.1 * kCutoffTolerance_V, 4, kRows));
  EXPECT_FALSE(IsBelowCutoff(cell, 1.0, 5.5, kRows - 1, kRows));
  EXPECT_TRUE(IsBelowCutoff(cell, 1.0, 5.3, kRows - 1, kRows));
  EXPECT_TRUE(IsBelowCutoff(cell, 1.0, 5.5, 0, 1))
      << "of a single row nothing comes before the end";
  EXPECT_TRUE(IsBelowCutoff(cell, 1.0, std::nan(""), 4, kRows));
  for (const double current_A : {0.0, -1.0})
    EXPECT_FALSE(IsBelowCutoff(cell, current_A, 5.0, 4, kRows)) << "an empty cell is charged";
}

class DischargeHolds : public testing::TestWithParam<Hold> {};
INSTANTIATE_TEST_SUITE_P(Both,
                         DischargeHolds,
                         testing::Values(Hold::kBackward, Hold::kForward),
                         [](const auto& each) {
                           return each.param == Hold::kBackward ? "Backward" : "Forward";
                         });

TEST_P(DischargeHolds, TimeRunsFromSwitchOnToTheInterpolatedCrossing) {
  const auto record = WithVoltage(
      RecordOfSteps({{100.0, 0.0, 10.0}, {1001.0, 2.0, 0.5}, {500.0, 0.0, 10.0}}, GetParam()),
      Falling);
  const auto discharge = FindDischarge(record, 3.0);
  EXPECT_EQ(discharge.start_s, 100.0);
  EXPECT_NEAR(discharge.time_s(), 1000.25, 1e-9);  // rounding of voltages over 1 mV/s
  EXPECT_NEAR(discharge.charge_C, 2000.5, 2e-9);
  EXPECT_NEAR(discharge.current_A, 2.0, 1e-12);
  EXPECT_EQ(discharge.end_voltage_V, 3.0);
}

TEST_P(DischargeHolds, VoltageWithinTheToleranceEndsItAtTheLastStampUnderLoad) {
  // Stops at 4 mV above cut-off; with forward hold the current flows on to the stamp after the last
  // row.
  const auto record = WithVoltage(
      RecordOfSteps({{100.0, 0.0, 10.0}, {996.0, 2.0, 1.0}, {500.0, 0.0, 10.0}}, GetParam()),
      Falling);
  const auto discharge = FindDischarge(record, 3.0);
  EXPECT_NEAR(discharge.time_s(), 996.0, 1e-9);
  EXPECT_NEAR(discharge.end_voltage_V, 3.00425, 1e-9);
}

TEST_P(DischargeHolds, CoarseRowsAreExtrapolatedToTheEndOfTheCurrent) {
  // 100 s rows: forward, the last voltage under load is measured 100 s before the current ends.
  const auto record = WithVoltage(
      RecordOfSteps({{100.0, 0.0, 10.0}, {1100.0, 2.0, 100.0}, {500.0, 0.0, 10.0}}, GetParam()),
      [](double t) { return t <= 1200.0 ? Falling(t) : 3.3; });
  EXPECT_NEAR(FindDischarge(record, 2.95).time_s(), 1050.25, 1e-9);
}

TEST(Discharge, WithoutARestRowStartsAtTheFirstStamp) {
  auto record = WithVoltage(RecordOfSteps({{1101.0, 2.0}}), Falling);
  record.current_A[0] = 2.0;
  EXPECT_NEAR(FindDischarge(record, 3.0).time_s(), 1100.25, 1e-9);
}

TEST(Discharge, CurrentIsChargeOverTime) {
  // 0.5 s at 1 A, then 2 A: the first row is an edge of the level.
  auto record = WithVoltage(
      RecordOfSteps({{100.0, 0.0, 10.0}, {0.5, 1.0, 0.5}, {1001.0, 2.0, 0.5}}), Falling);
  const auto discharge = FindDischarge(record, 3.0);
  EXPECT_NEAR(discharge.charge_C, 2000.0, 2e-9);
  EXPECT_NEAR(discharge.current_A, 2000.0 / 1000.25, 1e-11);
}

TEST(Discharge, NoiseOfTheVoltageDoesNotEndItEarly) {
  // 4 mV of noise at 10 rows per second, falling 1 mV/s: the first noisy row below 3 V comes some
  // 14 s early.
  for (unsigned seed = 1; seed <= 10; ++seed) {
    auto record = WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {1020.0, 2.0, 0.1}}), Falling);
    std::mt19937 engine(seed);
    std::normal_distribution<double> noise(0.0, 0.004);
    for (double& v : record.voltage_V) v += noise(engine);
    const auto discharge = FindDischarge(record, 3.0);
    EXPECT_NEAR(discharge.voltage_noise_V, 0.004, 0.0003);
    // Groups of 50 rows: 0.57 mV each, so 0.57 s, four times; the search for a first crossing is
    // early by one group at most.
    EXPECT_NEAR(discharge.time_s(), 1000.25, 5.0) << seed;
  }
}

TEST(Discharge, SlopeBeforeASharpKneeIsNotSmoothedAway) {
  // The last 60 s fall by 10 mV/s, the noise is 1 mV.
  auto record = WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {3600.0, 2.0, 1.0}}),
                            [](double t) { return t < 3640.0 ? 3.6 : 3.6 - 0.01 * (t - 3640.0); });
  std::mt19937 engine(5);
  std::normal_distribution<double> noise(0.0, 0.001);
  for (double& v : record.voltage_V) v += noise(engine);
  EXPECT_NEAR(FindDischarge(record, 3.005).time_s(), 3599.5, 0.3);
}

std::string Refusal(const Record& record, double cutoff_V) {
  return LoadErrorOf([&] { (void)FindDischarge(record, cutoff_V); });
}

TEST(Discharge, RefusesOneThatNeverReachesCutOff) {
  const auto record = WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {800.0, 2.0}}), Falling);
  EXPECT_EQ(Refusal(record, 3.0),
            "synthetic.csv:1:1: error: expected the voltage to reach the cut-off of 3 V within 5 "
            "mV, found 3.2003 V "
            "as the lowest under load, at 900 s; if the cell was empty there, set cutoff_V to that "
            "voltage; else log the discharge to its end, or call it one of kind \"validation\"");
}

// A cycler stops when the voltage reaches the cut-off, which may be between two rows: a last row that
// is as far above it as the row before fell is the end. 10 mV/s at the end, rows of 1 s.
TEST(Discharge, MayEndWithinTwoRowsOfTheCutOff) {
  const auto record =
      WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {3600.0, 2.0, 1.0}}),
                  [](double t) { return t < 3640.0 ? 3.6 : 3.6 - 0.01 * (t - 3640.0); });
  const double last_V = record.voltage_V.back();
  EXPECT_NEAR(FindDischarge(record, last_V - 0.019).time_s(), 3600.0, 1.0);
  EXPECT_NE(Refusal(record, last_V - 0.021).find("within 20 mV"), std::string::npos);
  // Where a row is more than a hundredth of the discharge, it is no small matter.
  const auto coarse = WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {800.0, 2.0, 20.0}}), Falling);
  EXPECT_NE(Refusal(coarse, coarse.voltage_V.back() - 0.006).find("within 5 mV"),
            std::string::npos);
}

TEST(Discharge, RefusesACutOffAboveItsStart) {
  const auto record = WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {800.0, 2.0}}), Falling);
  EXPECT_EQ(Refusal(record, 4.2),
            "synthetic.csv:1:1: error: expected a discharge that starts above the cut-off of 4.2 "
            "V, found 3.999 V in "
            "the first row under load");
}

TEST(Discharge, RefusesACurrentAlone) {
  auto record = test::RecordOfSteps({{60.0, 0.0}, {3600.0, 2.0}});
  record.voltage_V.clear();
  const std::string none = "synthetic.csv:1:1: error: expected a log with voltages, found none";
  EXPECT_EQ(Refusal(record, 3.0), none);
  EXPECT_EQ(LoadErrorOf([&] { (void)FindLowRateDischarge(record, 2.0); }), none);
}

TEST(Discharge, RefusesACurrentThatIsNotConstant) {
  const auto record =
      WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {700.0, 2.0}, {301.0, 1.0}}), Falling);
  EXPECT_EQ(Refusal(record, 3.0),
            "synthetic.csv:1:1: error: expected one discharge at constant current, found 18 % of "
            "the charge at over "
            "10 % from the median of 2 A (rows from 1 A to 2 A)");
}

TEST(Discharge, RefusesPulses) {
  const auto record =
      RecordOfSteps({{100.0, 0.0, 10.0}, {100.0, 2.0}, {300.0, 0.0}, {100.0, 2.0}, {100.0, 0.0}});
  EXPECT_EQ(Refusal(record, 3.0),
            "synthetic.csv:1:1: error: expected one discharge at constant current, found 1 rest "
            "inside it, 300 s of "
            "500 s; a log of pulses is of kind \"pulses\"");
}

TEST(Discharge, RefusesCharging) {
  EXPECT_EQ(Refusal(RecordOfSteps({{100.0, 0.0}, {3600.0, -2.0}}), 3.0),
            "synthetic.csv:1:1: error: expected one discharge at constant current, found 2 Ah of "
            "charging beside 0 Ah "
            "of discharging; choose the part of the log with steps, cycles or start_s and end_s, "
            "or settle the sign "
            "with current_sign");
}

TEST(Discharge, RefusesRest) {
  EXPECT_EQ(Refusal(RecordOfSteps({{100.0, 0.0}}), 3.0),
            "synthetic.csv:1:1: error: expected one discharge at constant current, found no "
            "current but rest over "
            "101 rows");
}

TEST(LowRate, NeedNotReachAnyCutOff) {
  const auto record =
      WithVoltage(RecordOfSteps({{100.0, 0.0, 10.0}, {36000.0, 0.2, 10.0}}), Falling);
  const auto discharge = FindLowRateDischarge(record, 2.0);
  EXPECT_EQ(discharge.time_s(), 36000.0);
  EXPECT_NEAR(discharge.charge_C, 7200.0, 1e-8);
}

TEST(LowRate, RefusesARateOverAFifthOfTheCapacity) {
  const auto record = RecordOfSteps({{100.0, 0.0, 10.0}, {7200.0, 1.0, 10.0}});
  const auto refusal = [&](double capacity_Ah) {
    return LoadErrorOf([&] { (void)FindLowRateDischarge(record, capacity_Ah); });
  };
  EXPECT_EQ(refusal(5.0), "no error");
  EXPECT_EQ(refusal(4.0),
            "synthetic.csv:1:1: error: expected a low rate, at most 0.2 C, found 0.25 C (1 A for a "
            "capacity of 4 Ah)");
  EXPECT_EQ(refusal(0.0),
            "synthetic.csv:1:1: error: expected a low rate, at most 0.2 C, found 0.5 C (1 A for a "
            "charge of 2 Ah)");
}

TEST(Pulses, NeedARestAfterALoad) {
  const auto refusal = [](const Record& record) {
    return LoadErrorOf([&] { (void)FindPulses(record); });
  };
  EXPECT_EQ(refusal(RecordOfSteps({{60.0, 0.0}, {30.0, 3.0}, {60.0, 0.0}})), "no error");
  EXPECT_EQ(refusal(RecordOfSteps({{60.0, 0.0}, {120.0, 3.0}, {120.0, 1.0}})),
            "synthetic.csv:1:1: error: expected pulses with rests between them, found 2 loads and "
            "no rest after any; "
            "a discharge is of kind \"constant-current\", any other load of kind \"validation\"");
  // A sensor whose zero is off by 10 mA: its rests are none.
  EXPECT_EQ(
      refusal(
          RecordOfSteps({{60.0, -0.01}, {30.0, 2.0}, {600.0, -0.01}, {30.0, 2.0}, {600.0, -0.01}})),
      "synthetic.csv:1:1: error: expected pulses with rests between them, found 4 loads and no rest after "
      "any; -0.01 A flow between them: if the cell rests there, the zero of the current sensor is off by "
      "that, and is to be subtracted first; a discharge is of kind \"constant-current\", any other load of "
      "kind \"validation\"");
  EXPECT_EQ(refusal(RecordOfSteps({{60.0, 0.0}})),
            "synthetic.csv:1:1: error: expected pulses, found no current but rest over 61 rows");
}

TEST(DischargesOfRealLogs, DischargeTimesAreThoseOfTheReadmes) {
  struct Case {
    const char* file;
    double cutoff_V, time_s, current_A;
  };
  // The last stamp where its voltage is the cut-off exactly; else interpolated by hand between the
  // last two rows.
  const Case cases[] = {
      {"nissan_leaf_33ah/cc_1c.csv", 3.0, 3568.8, 30.6},
      {"nissan_leaf_33ah/cc_2c.csv", 3.0, 1763.0, 61.2},
      {"nissan_leaf_33ah/cc_3c.csv", 3.0, 1126.4, 91.8},
      {"dmegc_inr18650_26_r1/cc_1c.csv", 2.5, 3498.0, 2.6008},
      {"dmegc_inr18650_26_r1/cc_2c.csv", 2.5, 1735.0, 5.1998},
      {"lg_m50_5ah/cc_0p5c.csv", 2.5, 6969.783 + 3.257 * 0.0092 / 0.00955, 2.49978},
      {"lg_m50_5ah/cc_1c.csv", 2.5, 3443.007 + 0.471 * 0.00201 / 0.00289, 4.9998}};
  for (const Case& each : cases) {
    const auto file = test::LabDataPath(each.file);
    LIPOID_SKIP_WITHOUT(file);
    const auto discharge = FindDischarge(test::ReadPlainCsv(file), each.cutoff_V);
    EXPECT_NEAR(discharge.time_s(), each.time_s, 1e-6) << each.file;
    EXPECT_NEAR(discharge.current_A, each.current_A, 0.002)
        << each.file;  // the instruments' last digits
  }
}

TEST(DischargesOfRealLogs, LowRatesAreLow) {
  for (const char* name : {"nissan_leaf_33ah/low_rate_lead_compensated.csv",
                           "dmegc_inr18650_26_r1/low_rate.csv",
                           "lg_m50_5ah/low_rate.csv"}) {
    const auto file = test::LabDataPath(name);
    LIPOID_SKIP_WITHOUT(file);
    EXPECT_NO_THROW((void)FindLowRateDischarge(test::ReadPlainCsv(file), 0.0)) << name;
  }
}

TEST(DischargesOfRealLogs, OfAnotherKindAreRefused) {
  const auto walk = test::LabDataPath("dmegc_inr18650_26_r1/random_walk_01.csv");
  const auto fast = test::LabDataPath("dmegc_inr18650_26_r1/cc_0p5c.csv");
  LIPOID_SKIP_WITHOUT(walk);
  EXPECT_NE(Refusal(test::ReadPlainCsv(walk), 2.5), "no error");
  const auto as_low_rate =
      LoadErrorOf([&] { (void)FindLowRateDischarge(test::ReadPlainCsv(fast), 2.6); });
  EXPECT_NE(as_low_rate.find("found 0.5 C (1.3 A for a capacity of 2.6 Ah)"), std::string::npos)
      << as_low_rate;
  EXPECT_NE(LoadErrorOf([&] { (void)FindPulses(test::ReadPlainCsv(walk)); }), "no error");
}

}  // namespace
}  // namespace lipoid
