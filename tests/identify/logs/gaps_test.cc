#include "identify/logs/gaps.h"

#include <gtest/gtest.h>

#include "tests/support/load_error.h"

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

}  // namespace
}  // namespace lipoid
