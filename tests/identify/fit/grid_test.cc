#include "identify/fit/grid.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

using Values = std::vector<double>;

TEST(Grid, PointsStandInEqualRatios) {
  const Values grid = GeometricGrid(0.5, 40.5, 5);
  ASSERT_EQ(grid.size(), 5U);
  EXPECT_EQ(grid.front(), 0.5);
  for (std::size_t k = 1; k < grid.size(); ++k) EXPECT_NEAR(grid[k] / grid[k - 1], 3.0, 1e-14);
  EXPECT_NEAR(GeometricGrid(4.0, 9.0, 1).at(0), 6.0, 1e-14);
}

TEST(Grid, ChoicesAreEachOnceAndRising) {
  EXPECT_EQ(Choices({1, 2, 3}, 0), (std::vector<Values>{{}}));
  EXPECT_EQ(Choices({1, 2, 3}, 2), (std::vector<Values>{{1, 2}, {1, 3}, {2, 3}}));
  EXPECT_EQ(Choices({1, 2, 3, 4, 5, 6}, 3).size(), 20U);  // 6!/(3! 3!)
  EXPECT_TRUE(Choices({1}, 2).empty());
}

}  // namespace
}  // namespace lipoid
