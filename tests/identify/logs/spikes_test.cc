#include "identify/logs/spikes.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

// A pulse of one row among them, whose voltage is real: 3.7 V less 0.05 V per ampere.
Record Pulses() {
  return test::RecordOfSteps(
      {{20.0, 0.0}, {20.0, 4.0}, {20.0, 0.0}, {1.0, 20.0}, {20.0, 0.0}, {20.0, 4.0}});
}

using RowNumbers = std::vector<std::size_t>;

TEST(Spikes, AreRowsThatTheirNeighboursKnowNothingOf) {
  Record record = Pulses();
  EXPECT_EQ(FindSpikes(record), RowNumbers{});
  record.voltage_V[30] = 10.0;
  record.voltage_V[75] = 0.0;
  EXPECT_EQ(FindSpikes(record), (RowNumbers{30, 75}));
}

// A sensor that does not answer while the load changes: no current takes the whole voltage, nor leaves it at its end.
TEST(Spikes, FewRowsWithoutAVoltageAreSpikesWhateverFlows) {
  Record record = Pulses();
  record.voltage_V[63] = 0.0;  // within the pulse of 20 A
  record.voltage_V[84] = record.voltage_V[85] = 0.1;
  EXPECT_EQ(FindSpikes(record), (RowNumbers{63, 84, 85}));
  for (std::size_t k = 90; k < 96; ++k) record.voltage_V[k] = 0.0;
  EXPECT_EQ(FindSpikes(record), (RowNumbers{63, 84, 85}));  // six are a fault of another kind
  // No cliff ends so deep: before the first answer, and after the last.
  Record ends = Pulses();
  ends.voltage_V[0] = 0.0;
  ends.voltage_V[1] = -1.0;
  ends.voltage_V.back() = 0.0;
  EXPECT_EQ(FindSpikes(ends), (RowNumbers{0, 1, ends.size() - 1}));
}

TEST(Spikes, RowsAtRestBeforeAndAfterTheCellHaveNone) {
  const Record record = Pulses();
  EXPECT_EQ(FindRowsWithoutCell(record).first, 0U);
  EXPECT_EQ(FindRowsWithoutCell(record).last, 0U);
  // The least of these is 2.7 V in the pulse of 20 A, and the range 1 V: below 2.2 V.
  Record ends = record;
  for (std::size_t k = 0; k < 7; ++k) ends.voltage_V[k] = 2.0;
  EXPECT_EQ(FindRowsWithoutCell(ends).first, 7U);
  for (std::size_t k = 0; k < 7; ++k) ends.voltage_V[k] = 2.4;
  EXPECT_EQ(FindRowsWithoutCell(ends).first, 0U);
  // Its last rows are a load of 4 A, after which the lead is open, in two steps.
  const double last_s = record.time_s.back();
  for (const double voltage_V : {2.4, 1.2, 1.25, 1.2}) {
    ends.time_s.push_back(last_s + 1.0 + static_cast<double>(ends.size() - record.size()));
    ends.current_A.push_back(0.0);
    ends.voltage_V.push_back(voltage_V);
  }
  EXPECT_EQ(FindRowsWithoutCell(ends).last, 3U);
  ends.voltage_V[record.size()] = 1.4;
  EXPECT_EQ(FindRowsWithoutCell(ends).last, 4U);
  for (std::size_t k = 0; k < 7; ++k) ends.voltage_V[k] = 1.2;  // at both ends
  EXPECT_EQ(FindRowsWithoutCell(ends).first, 7U);
  EXPECT_EQ(FindRowsWithoutCell(ends).last, 4U);
  // Under a load it is another matter.
  for (std::size_t k = record.size(); k < ends.size(); ++k) ends.current_A[k] = 4.0;
  EXPECT_EQ(FindRowsWithoutCell(ends).last, 0U);
}

// The current changes there and back, and the voltage follows it the wrong way.
TEST(Spikes, ACurrentThatChangesTheSameWayExplainsNothing) {
  Record record = Pulses();
  record.current_A[30] = 2.0;  // of 4 A, while the voltage falls
  record.voltage_V[30] = 1.5;
  EXPECT_EQ(FindSpikes(record), RowNumbers{30});
}

// A real pulse of one row moves the voltage, at once or in the next row.
TEST(Spikes, ACurrentThatTheVoltageDoesNotFollowIsOne) {
  Record record = Pulses();
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{});
  record.current_A[30] = 60.0;  // of 4 A
  record.current_A[75] = -45.0;
  EXPECT_EQ(FindCurrentSpikes(record), (RowNumbers{30, 75}));
  record.current_A[75] = 5.0;  // within what the others have
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{30});
  record.voltage_V[31] -= 2.0;  // a logger that reads the voltage a row later
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{});
  // A steady load, and no step to compare with.
  record = test::RecordOfSteps({{100.0, 2.0}});
  record.current_A[0] = 2.0;
  record.current_A[50] = 9.0;
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{});
  record.current_A[50] = 30.0;
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{50});
  record.voltage_V.clear();
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{});
  // Pulses of a logger so slow that each is one row, and the voltage has recovered by the next.
  record = test::RecordOfSteps({{100.0, 0.0}});
  record.current_A[30] = record.current_A[60] = 2.0;
  EXPECT_EQ(FindCurrentSpikes(record), RowNumbers{});
}

TEST(Spikes, TheFirstAndTheLastRowAreNone) {
  Record record = Pulses();
  record.voltage_V.front() = 10.0;
  record.voltage_V.back() = 2.0;  // a discharge that ends on a cliff
  EXPECT_EQ(FindSpikes(record), RowNumbers{});
}

TEST(Spikes, AStepOfTheCurrentExplainsAStepOfTheVoltage) {
  // At rest, then 8 A to the end: the first row lies alone above all others.
  Record record = test::RecordOfSteps({{100.0, 8.0}});
  EXPECT_EQ(FindSpikes(record), RowNumbers{});
  // One row of 60 A.
  record = test::RecordOfSteps({{20.0, 1.0}, {1.0, 60.0}, {20.0, 1.0}});
  EXPECT_EQ(FindSpikes(record), RowNumbers{});
}

TEST(Spikes, TwoWrongRowsTogetherAreNone) {
  Record record = Pulses();
  record.voltage_V[30] = record.voltage_V[31] = 10.0;  // CheckPlausible() refuses these
  EXPECT_EQ(FindSpikes(record), RowNumbers{});
  EXPECT_EQ(FindSpikes(Record{}), RowNumbers{});
}

// ---- temperatures ------------------------------------------------------------------------------

class Temperatures : public testing::Test {
 protected:
  // 25 degC, warming by 10 K in an hour, with a row every 2 s.
  Temperatures() {
    for (int k = 0; k < 1800; ++k) {
      time_s.push_back(2.0 * k);
      degC.push_back(25.0 + 10.0 * k / 1800.0);
    }
  }
  [[nodiscard]] FailedTemperatures Failed() const { return FindFailedTemperatures(time_s, degC); }
  std::vector<double> time_s, degC;
};

TEST_F(Temperatures, OfACellNeverFail) {
  EXPECT_TRUE(Failed().rows.empty() && !Failed().no_way_back);
  for (std::size_t k = 900; k < degC.size(); ++k) {
    time_s[k] += 600.0;  // out of the chamber and into another one
    degC[k] -= 30.0;
  }
  EXPECT_TRUE(Failed().rows.empty() && !Failed().no_way_back);
}

TEST_F(Temperatures, ThatJumpThereAndBackFail) {
  std::vector<std::size_t> expected;
  for (std::size_t k = 0; k < degC.size(); k += 50) {
    degC[k] = k % 100 == 0 ? 85.0 : 0.0;  // the first and the last but few, too
    expected.push_back(k);
  }
  EXPECT_EQ(Failed().rows, expected);
  EXPECT_FALSE(Failed().no_way_back);
  degC.resize(1751);
  time_s.resize(1751);
  expected.resize(36);  // 1750 is the last row now
  EXPECT_EQ(Failed().rows, expected);
}

TEST_F(Temperatures, OfASensorThatCameOffHaveNoWayBack) {
  for (std::size_t k = 700; k < degC.size(); ++k) degC[k] = 0.0;
  EXPECT_EQ(Failed().no_way_back, 700U);
  for (std::size_t k = 1500; k < degC.size(); ++k) degC[k] = 30.0;  // it is put on again
  EXPECT_EQ(Failed().rows.size(), 800U);
  EXPECT_EQ(Failed().rows.front(), 700U);
}

}  // namespace
}  // namespace lipoid
