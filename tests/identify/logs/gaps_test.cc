#include "identify/logs/gaps.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

std::vector<double> Times(std::initializer_list<std::pair<int, double>> parts) {
  std::vector<double> time_s{0.0};
  for (const auto& [rows, interval_s] : parts) {
    for (int k = 0; k < rows; ++k) time_s.push_back(time_s.back() + interval_s);
  }
  return time_s;
}

TEST(Gaps, AreMuchLongerThanTheSamplingOnBothSides) {
  const auto gaps = FindGaps(Times({{20, 1.0}, {1, 30.0}, {20, 1.0}}));
  ASSERT_EQ(gaps.size(), 1U);
  EXPECT_EQ(gaps[0].row, 21U);
  EXPECT_EQ(gaps[0].start_s, 20.0);
  EXPECT_EQ(gaps[0].length_s, 30.0);
}

TEST(Gaps, AChangeOfTheSamplingIsNone) {
  EXPECT_TRUE(FindGaps(Times({{20, 1.0}, {20, 60.0}, {20, 0.1}, {20, 5.0}})).empty());
  EXPECT_TRUE(FindGaps(Times({{20, 1.0}, {1, 9.0}, {20, 1.0}})).empty());
  EXPECT_TRUE(FindGaps({}).empty());
  EXPECT_TRUE(FindGaps({1.0, 100.0}).empty());
}

TEST(Gaps, AreFoundNearTheEnds) {
  EXPECT_EQ(FindGaps(Times({{1, 1.0}, {1, 30.0}})).size(), 1U);
  EXPECT_EQ(FindGaps(Times({{2, 1.0}, {1, 30.0}, {1, 1.0}})).size(), 1U);
}

}  // namespace
}  // namespace lipoid
