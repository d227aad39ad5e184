#include "identify/health/trend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace lipoid {
namespace {

TEST(Trend, OfTheSameShareInEachFlightIsThatShare) {
  std::vector<TrendPoint> points;
  for (int k = 0; k < 11; ++k) points.push_back({double(k), 2.0 * std::pow(0.75, 0.1 * k), 0.01});
  const auto trend = FitTrend(points);
  ASSERT_TRUE(trend);
  constexpr double kRounding = 1e-9;
  EXPECT_EQ(trend->flights, 11U);
  EXPECT_NEAR(trend->first.value, 2.0, kRounding);
  EXPECT_NEAR(trend->last.value, 1.5, kRounding);
  EXPECT_NEAR(trend->change_percent.value, -25.0, kRounding);
  EXPECT_NEAR(trend->per_flight_percent.value, -2.5, kRounding);
  EXPECT_NEAR(trend->change_percent.high - trend->change_percent.low, 0.0, 1e-6);
}

// The interval of the slope of an ordinary line, from a textbook: n = 4, y = 1, 2, 2, 3 at 0, 1, 2, 3
// has slope 0.6 and its standard error sqrt(0.1/5) (sum of squares 0.2 over n - 2, Sxx = 5).
TEST(Trend, IntervalIsStudents) {
  const double y[] = {1.0, 2.0, 2.0, 3.0};
  std::vector<TrendPoint> points;
  for (int k = 0; k < 4; ++k) points.push_back({double(k), std::exp(y[k]), 0.1});
  const auto trend = FitTrend(points);
  ASSERT_TRUE(trend);
  constexpr double kStudent2 = 4.302653;  // 97.5 %, two degrees of freedom
  EXPECT_NEAR(std::log(trend->last.value / trend->first.value), 3.0 * 0.6, 1e-9);
  // At the end of the line the variance is s² (1/4 + 1.5²/5).
  const double half = kStudent2 * std::sqrt(0.1 * (0.25 + 2.25 / 5.0));
  EXPECT_NEAR(std::log(trend->last.high / trend->last.value), half, 1e-5);
}

// Three flights that contradict one another: the line may fall far, but no quantity loses more than all.
TEST(Trend, NothingLosesMoreThanItHas) {
  const std::vector<TrendPoint> points{{0.0, 1.8, 0.1}, {1.0, 4.0, 0.1}, {2.0, 1.8, 0.1}};
  const auto trend = FitTrend(points);
  ASSERT_TRUE(trend);
  EXPECT_GT(trend->first.low, 0.0);
  EXPECT_GT(trend->last.low, 0.0);
  EXPECT_GT(trend->change_percent.low, -100.0);
}

TEST(Trend, OfTwoFlightsIsNone) {
  const std::vector<TrendPoint> two{{0.0, 1.0, 0.1}, {1.0, 0.9, 0.1}};
  EXPECT_FALSE(FitTrend(two));
}

}  // namespace
}  // namespace lipoid
