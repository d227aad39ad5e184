#include "identify/logs/gaps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/load_error.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

struct Stretch {
  int rows = 0;
  double interval_s = 1.0;
  double current_A = 2.0;
};

// Rows that follow one at time 0; the voltage falls with the charge, 1 V in all.
Record Rows(std::initializer_list<Stretch> stretches) {
  Record record;
  record.file = "F";
  record.time_s = {0.0};
  record.current_A = {stretches.begin()->current_A};
  record.voltage_V = {4.2};
  for (const auto& [rows, interval_s, current_A] : stretches) {
    for (int k = 0; k < rows; ++k) {
      record.time_s.push_back(record.time_s.back() + interval_s);
      record.current_A.push_back(current_A);
      record.voltage_V.push_back(record.voltage_V.back() - 1e-4 * interval_s * current_A);
    }
  }
  return record;
}

TEST(Gaps, AreMuchLongerThanTheSamplingOnBothSides) {
  const auto gaps = FindGaps(Rows({{20, 1.0}, {1, 30.0}, {20, 1.0}}));
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].row, 21U);
  EXPECT_EQ(gaps[0].start_s, 20.0);
  EXPECT_EQ(gaps[0].length_s, 30.0);
  EXPECT_EQ(gaps[0].unknown_C, 60.0);
}

TEST(Gaps, AChangeOfTheSamplingIsNone) {
  EXPECT_TRUE(FindGaps(Rows({{20, 1.0}, {20, 60.0}, {20, 0.1}, {20, 5.0}})).empty());
  EXPECT_TRUE(FindGaps(Rows({{20, 1.0}, {1, 9.0}, {20, 1.0}})).empty());
  EXPECT_TRUE(FindGaps(Record{}).empty());
}

TEST(Gaps, AreFoundNearTheEnds) {
  EXPECT_EQ(FindGaps(Rows({{1, 1.0}, {1, 30.0}})).size(), 1U);
  EXPECT_EQ(FindGaps(Rows({{2, 1.0}, {1, 30.0}, {1, 1.0}})).size(), 1U);
}

// Its two ends at rest: nothing flowed.
TEST(Gaps, ALongIntervalAtRestIsARest) {
  EXPECT_TRUE(
      FindGaps(Rows({{20, 1.0, 2.0}, {5, 1.0, 0.0}, {1, 3600.0, 0.0}, {20, 1.0, 0.0}})).empty());
  // The load at one end may have been there all the time, or not.
  const auto gaps = FindGaps(Rows({{20, 1.0, 0.0}, {1, 100.0, 2.0}, {20, 1.0, 2.0}}));
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].unknown_C, 200.0);
}

// Two pulses were lost with their rows. A cell that rests after a discharge recovers, and one that rests after
// a charge falls.
TEST(Gaps, ARestAcrossWhichTheVoltageMovesAgainstItsRelaxationHidesALoad) {
  const auto gaps = [](double load_A, double move_V) {
    Record record = Rows({{20, 1.0, load_A}, {10, 1.0, 0.0}, {1, 3600.0, 0.0}, {20, 1.0, 0.0}});
    for (std::size_t k = 31; k < record.size(); ++k) record.voltage_V[k] += move_V;
    return FindGaps(record);
  };
  const auto hidden = gaps(2.0, -0.045);
  ASSERT_EQ(hidden.size(), 1U);
  EXPECT_EQ(hidden[0].start_s, 30.0);
  EXPECT_EQ(hidden[0].unknown_C, 2.0 * 3600.0);
  EXPECT_EQ(gaps(-2.0, 0.045).size(), 1U);
  EXPECT_TRUE(gaps(2.0, 0.045).empty());
  EXPECT_TRUE(gaps(-2.0, -0.045).empty());
  EXPECT_TRUE(gaps(2.0, -0.01).empty()) << "days of self-discharge";
  EXPECT_TRUE(gaps(0.0, -0.045).empty()) << "what was before the log is not known";
}

// A logger that writes a row when the voltage has moved by 1 mV waits where the curve is flat.
TEST(Gaps, SamplingByChangeHasNone) {
  Record record;
  for (const double interval_s : {1.0, 2.0, 4.0, 7.0, 3.0, 200.0, 5.0, 2.0, 8.0, 3.0, 1.0}) {
    const double last_s = record.time_s.empty() ? 0.0 : record.time_s.back();
    record.time_s.push_back(last_s + interval_s);
    record.current_A.push_back(2.0);
    record.voltage_V.push_back(4.0 - 0.001 * static_cast<double>(record.time_s.size()));
  }
  EXPECT_TRUE(FindGaps(record).empty());
  // But a voltage that moved on meanwhile was not seen.
  for (std::size_t k = 5; k < record.size(); ++k) record.voltage_V[k] -= 0.05;
  EXPECT_EQ(FindGaps(record).size(), 1U);
}

TEST(Gaps, OfUnknownChargeAreRefusedWithWhatCanBeRead) {
  const Record record = Rows({{100, 1.0}, {1, 30.0}, {100, 1.0}});
  const auto refuse = [&](double capacity_Ah) {
    return test::LoadErrorOf([&] { RefuseUnknownCharge(record, FindGaps(record), capacity_Ah); });
  };
  EXPECT_EQ(
      refuse(0.0),
      "F:1:1: error: expected rows wherever a current flows, found a gap of 30 s after 100 s, "
      "in which up to 0.0167 Ah may have flowed: the state of charge after it is not known; "
      "read the part before it (end_s = 100), or the part after it (start_s = 130) with its "
      "own initial_soc, or save the parts as files of their own (lipoid convert --end-s 100, and --start-s 130)");
  // Of 10 Ah these 60 C are less than two thousandths, of 5 Ah more.
  EXPECT_EQ(refuse(10.0), "no error");
  EXPECT_NE(refuse(5.0), "no error");
}

// Rows each 10 minutes, between two of which a clock is put forward: 7 times the usual interval.
TEST(Gaps, AClockThatIsPutForwardLeavesAnHour) {
  Record record = test::RecordOfSteps({{1200.0, 0.0, 600.0}, {36000.0, 0.1, 600.0}});
  EXPECT_TRUE(FindGaps(record).empty());
  for (std::size_t k = 30; k < record.size(); ++k) record.time_s[k] += 3600.0;
  const auto gaps = FindGaps(record);
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].row, 30U);
  EXPECT_EQ(GapsText(gaps),
            "a gap of 4200 s after 17400 s, in which up to 0.117 Ah may have flowed");
  EXPECT_EQ(GapsHint(gaps),
            " (if a clock was put forward to summer time, export the time since the start)");
  record.time_s[29] += 300.0;  // a logger of no steady interval
  EXPECT_TRUE(FindGaps(record).empty());
}

// A pulse test whose rests fall from `full_V` to `empty_V`.
Record FallingPulses(double full_V, double empty_V) {
  std::vector<test::CurrentStep> steps;
  for (int k = 0; k < 10; ++k) {
    steps.push_back({600.0, 0.0, 10.0});
    steps.push_back({300.0, 2.0, 10.0});
  }
  steps.push_back({600.0, 0.0, 10.0});
  Record record = test::RecordOfSteps(steps);
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double share = static_cast<double>(k) / static_cast<double>(record.size());
    record.voltage_V[k] += full_V + share * (empty_V - full_V) - 3.7;
  }
  return record;
}

void AppendTest(Record& record, Record next) {
  const double end_s = record.time_s.back() + 1.0;
  for (std::size_t k = 0; k < next.size(); ++k) {
    record.time_s.push_back(end_s + next.time_s[k]);
    record.current_A.push_back(next.current_A[k]);
    record.voltage_V.push_back(next.voltage_V[k]);
  }
}

void AddDrive(Record& record) {
  for (int k = 0; k < 600; ++k) {
    const int phase = (k + 10) % 20;
    const double current_A = phase == 0 ? 0.0 : phase < 5 ? -3.0 : 3.0;
    record.time_s.push_back(record.time_s.back() + 1.0);
    record.current_A.push_back(current_A);
    record.voltage_V.push_back(current_A > 0.0 ? 3.6 : 4.18);
  }
}

TEST(UnseenRecharge, IsWhereTheRestIsAsHighAgain) {
  Record record = FallingPulses(4.2, 3.6);
  EXPECT_TRUE(FindUnseenRecharges(record).empty());
  const std::size_t rows = record.size();
  AppendTest(record, FallingPulses(4.19, 3.6));
  const auto found = FindUnseenRecharges(record);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_EQ(found[0].row, rows);
  EXPECT_TRUE(found[0].recharge);
  EXPECT_NEAR(found[0].unknown_C, 10 * 300 * 2.0, 1e-6);
  EXPECT_EQ(
      GapsText(found),
      "a recharge of some 1.67 Ah between 9600 and 9601 s, where the voltage at rest comes back without a "
      "current, as where a test begins anew");
  Record fuller = FallingPulses(4.2, 3.6);
  AppendTest(fuller, FallingPulses(4.22, 3.6));
  EXPECT_EQ(FindUnseenRecharges(fuller).size(), 1U);
  // A charge that the rows hold explains it.
  Record charged = FallingPulses(4.2, 3.6);
  AppendTest(charged, test::RecordOfSteps({{3000.0, -2.0, 10.0}}));
  AppendTest(charged, FallingPulses(4.19, 3.6));
  EXPECT_TRUE(FindUnseenRecharges(charged).empty());
  // In a drive cycle the current passes zero on its way to a charge, whose drop is there for one row.
  Record drive = FallingPulses(4.2, 3.9);
  AddDrive(drive);
  EXPECT_TRUE(FindUnseenRecharges(drive).empty());
  // A flat curve, whose rest is nearly as high after each load, and rests that relax for long.
  EXPECT_TRUE(FindUnseenRecharges(FallingPulses(3.33, 3.28)).empty());
  Record slow = FallingPulses(3.5, 3.5);
  double since_s = 0.0;
  for (std::size_t k = 1; k < slow.size(); ++k) {
    since_s = slow.current_A[k] > 0.0 ? 0.0 : since_s + slow.time_s[k] - slow.time_s[k - 1];
    slow.voltage_V[k] -= 0.4 * std::exp(-since_s / 60.0);
  }
  EXPECT_TRUE(FindUnseenRecharges(slow).empty());
}

}  // namespace
}  // namespace lipoid
