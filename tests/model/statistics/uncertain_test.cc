#include "model/statistics/uncertain.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lipoid {
namespace {

TEST(Uncertain, DrawsHaveItsMeanAndStandardError) {
  const Uncertain number{5.0, 0.5};
  constexpr int kDraws = 20000;
  double sum = 0.0;
  double squares = 0.0;
  for (int k = 0; k < kDraws; ++k) {
    NormalNoise normal(1, static_cast<std::uint32_t>(k));
    const double drawn = number.Draw(normal, Range{});
    sum += drawn;
    squares += (drawn - 5.0) * (drawn - 5.0);
  }
  // Four standard errors of a mean and of a standard deviation over so many draws.
  EXPECT_NEAR(sum / kDraws, 5.0, 4.0 * 0.5 / std::sqrt(kDraws));
  EXPECT_NEAR(std::sqrt(squares / kDraws), 0.5, 4.0 * 0.5 / std::sqrt(2.0 * kDraws));
}

TEST(Uncertain, DrawsStayInRange) {
  for (std::uint32_t k = 0; k < 100; ++k) {
    NormalNoise normal(1, k);
    const double drawn = Uncertain{0.5, 3.0}.Draw(normal, Range{0.0, 1.0});
    EXPECT_GE(drawn, 0.0);
    EXPECT_LE(drawn, 1.0);
  }
}

TEST(Uncertain, AKnownNumberTakesItsShareOfTheNoise) {
  NormalNoise one(7, 0);
  NormalNoise other(7, 0);
  EXPECT_EQ((Uncertain{2.0, 0.0}.Draw(one, Range{})), 2.0);
  (void)Uncertain{2.0, 1.0}.Draw(other, Range{});
  EXPECT_EQ(one(), other());
}

}  // namespace
}  // namespace lipoid
