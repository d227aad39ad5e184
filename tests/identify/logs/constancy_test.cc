#include "identify/logs/constancy.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

using test::RecordOfSteps;

TEST(Constancy, IsLostWhenMoreThanATwentiethOfTheChargeFlowsFarFromTheMedian) {
  // 1000 s at 2 A, then x s at 2.3 A: the share off the median is 2.3 x / (2000 + 2.3 x).
  const auto share = [](double off_s) { return 2.3 * off_s / (2000.0 + 2.3 * off_s); };
  const auto few = RecordOfSteps({{1000.0, 2.0}, {45.0, 2.3}});
  const auto many = RecordOfSteps({{1000.0, 2.0}, {46.0, 2.3}});
  EXPECT_NEAR(MeasureConstancy(few, 1, few.size() - 1).charge_off_median, share(45.0), 1e-12);
  EXPECT_TRUE(MeasureConstancy(few, 1, few.size() - 1).constant());  // 4.92 %
  EXPECT_NEAR(MeasureConstancy(many, 1, many.size() - 1).charge_off_median, share(46.0), 1e-12);
  EXPECT_FALSE(MeasureConstancy(many, 1, many.size() - 1).constant());  // 5.02 %
}

TEST(Constancy, AllowsTenPercentFromTheMedian) {
  const auto near = RecordOfSteps({{600.0, 2.0}, {400.0, 2.19}});
  EXPECT_EQ(MeasureConstancy(near, 1, near.size() - 1).charge_off_median, 0.0);
  const auto far = RecordOfSteps({{600.0, 2.0}, {400.0, 2.21}});
  EXPECT_GT(MeasureConstancy(far, 1, far.size() - 1).charge_off_median, 0.4);
}

TEST(Constancy, MedianIsOverTimeAndNotOverRows) {
  // 600 rows in a minute at 3 A, then an hour at 1 A in 60 rows.
  const auto record = RecordOfSteps({{60.0, 3.0, 0.1}, {3600.0, 1.0, 60.0}});
  EXPECT_DOUBLE_EQ(MeasureConstancy(record, 1, record.size() - 1).median_A, 1.0);
}

TEST(Constancy, SeesThroughNoiseOfTheRows) {
  const auto record = RecordOfSteps({{40000.0, 0.05}}, Hold::kBackward, 0.02);
  const auto constancy = MeasureConstancy(record, 1, record.size() - 1);
  EXPECT_TRUE(constancy.constant());
  EXPECT_NEAR(
      constancy.median_A, 0.05, 5 * 0.02 / 200.0);  // five deviations of the mean of 40 000 rows
}

TEST(Constancy, DoesNotTakeASquareWaveForNoise) {
  std::vector<test::CurrentStep> steps;
  for (int k = 0; k < 200; ++k) steps.push_back({1.0, k % 2 == 0 ? 2.0 : 0.0});
  const auto record = RecordOfSteps(steps);
  EXPECT_FALSE(MeasureConstancy(record, 1, record.size() - 1).constant());
}

TEST(RowNoise, IsTheDeviationOfNormalNoise) {
  const auto record = RecordOfSteps({{50000.0, 1.0}, {50000.0, 3.0}}, Hold::kBackward, 0.02);
  EXPECT_NEAR(
      RowNoise(record.current_A, 0, record.size() - 1), 0.02, 0.0005);  // of 65 000 rows: 1 %
}

TEST(RowNoise, IgnoresStepsAndSlopes) {
  std::vector<double> values;
  for (int k = 0; k < 1000; ++k) values.push_back((k / 10) % 2 + 0.001 * k);
  EXPECT_EQ(RowNoise(values, 0, values.size() - 1), 0.0);
}

TEST(RowDuration, OfBothHoldsAddsUpToTheRecord) {
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    const auto record = RecordOfSteps({{10.0, 1.0, 0.5}, {100.0, 0.0, 20.0}}, hold);
    double sum_s = 0.0;
    for (std::size_t k = 0; k < record.size(); ++k) sum_s += RowDuration(record, k);
    EXPECT_EQ(sum_s, 110.0);
    EXPECT_EQ(RowDuration(record, 0), hold == Hold::kBackward ? 0.0 : 0.5);
  }
}

}  // namespace
}  // namespace lipoid
