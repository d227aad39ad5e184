#include "model/statistics/order_statistics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lipoid {
namespace {

TEST(Median, HasAsManyValuesBelowAsAbove) {
  for (const auto& values : {std::vector{2.0}, {9.0, 1.0, 2.0}, {7.0, 2.0, -1.0, 8.0, 0.0}}) {
    EXPECT_EQ(Median(values), 2.0);
    EXPECT_EQ(UpperMedian(values), 2.0);
  }
}

TEST(Median, OfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(Median({4.0, 1.0}), 2.5);
  EXPECT_EQ(UpperMedian({4.0, 1.0}), 4.0);
  EXPECT_EQ(Median({10.0, 1.0, 2.0, -5.0}), 1.5);
  EXPECT_EQ(UpperMedian({10.0, 1.0, 2.0, -5.0}), 2.0);
}

TEST(Median, OfNoneIsNone) {
  EXPECT_TRUE(std::isnan(Median({})));
  EXPECT_TRUE(std::isnan(UpperMedian({})));
}

}  // namespace
}  // namespace lipoid
