#include "model/core/significant_digits.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lipoid {
namespace {

TEST(RoundToDigits, GivesTheNumberThatAPersonWouldWrite) {
  EXPECT_EQ(RoundToDigits(6.0 * 0.6, 12), 3.6);
  EXPECT_EQ(RoundToDigits(331.0 * 0.1, 3), 33.1);
  EXPECT_EQ(RoundToDigits(-0.000123456, 2), -0.00012);
  EXPECT_EQ(RoundToDigits(98765.0, 1), 100000.0);
  EXPECT_EQ(RoundToDigits(0.0, 5), 0.0);
  EXPECT_EQ(RoundToDigits(std::numeric_limits<double>::infinity(), 5),
            std::numeric_limits<double>::infinity());
  EXPECT_TRUE(std::isnan(RoundToDigits(std::numeric_limits<double>::quiet_NaN(), 5)));
}

}  // namespace
}  // namespace lipoid
