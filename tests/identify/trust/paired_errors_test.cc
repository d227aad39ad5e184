#include "identify/trust/paired_errors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/core/special_values.h"

namespace lipoid {
namespace {

constexpr double kRoundingOfErrors = 1e-14;

// Two units of weight 1, differences 3 and 1: mean 2, standard error sqrt(2/4 (1 + 1)) = 1.
TEST(PairedErrors, AreTheTextbooksForEqualWeights) {
  const PairedGain gain = CompareErrors({5.0, 4.0}, {2.0, 3.0}, {1.0, 1.0});
  EXPECT_NEAR(gain.gain, 2.0, kRoundingOfErrors);
  EXPECT_NEAR(gain.standard_error, 1.0, kRoundingOfErrors);
  EXPECT_FALSE(gain.AskedFor());  // by no two units
  // Two standard errors of a normal distribution.
  EXPECT_NEAR(gain.Probability(), 0.977249868, 1e-9);
}

TEST(PairedErrors, WhatIsHardForBothModelsDropsOut) {
  const PairedGain gain =
      CompareErrors({5.0, 1004.0, 7.0, 3.0, 9.0}, {4.0, 1003.0, 6.0, 2.0, 8.0}, {1, 1, 1, 1, 1});
  EXPECT_NEAR(gain.gain, 1.0, kRoundingOfErrors);
  EXPECT_NEAR(gain.standard_error, 0.0, 1e-12);
  EXPECT_TRUE(gain.AskedFor());
}

// Sums carry their weights: a unit of weight 3 counts three times as much.
TEST(PairedErrors, UnitsCountWithTheirWeights) {
  const PairedGain gain = CompareErrors({6.0, 1.0}, {3.0, 2.0}, {3.0, 1.0});
  EXPECT_NEAR(gain.gain, (3.0 - 1.0) / 4.0, kRoundingOfErrors);
  // Off the mean: 3 - 3/2 and -1 - 1/2.
  EXPECT_NEAR(gain.standard_error, std::sqrt(2.0 * (2.25 + 2.25)) / 4.0, kRoundingOfErrors);
  EXPECT_FALSE(gain.AskedFor());
}

// One unit that is predicted much worse does not outvote six that are predicted better, nor the other
// way round: the mean goes with the first, the ranks with the six.
TEST(PairedErrors, EveryUnitHasItsSay) {
  const std::vector<double> weight(7, 1.0);
  std::vector<double> few{2.0, 2.1, 2.2, 2.3, 2.4, 2.5, 30.0};
  std::vector<double> many{1.9, 1.9, 1.9, 1.9, 1.9, 1.9, 29.0};
  // Ranks 1 to 7, all on one side.
  EXPECT_NEAR(CompareErrors(few, many, weight).ranks, 28.0 / std::sqrt(140.0), kRoundingOfErrors);
  EXPECT_TRUE(CompareErrors(few, many, weight).AskedFor());
  few.back() = 1e4;  // however much worse
  EXPECT_NEAR(CompareErrors(few, many, weight).ranks, 28.0 / std::sqrt(140.0), kRoundingOfErrors);
  few.back() = 28.0;  // rank 7 on the other side: the mean still gains, the ranks are not sure
  EXPECT_GT(CompareErrors(few, many, weight).gain, 0.0);
  EXPECT_NEAR(CompareErrors(few, many, weight).ranks, 14.0 / std::sqrt(140.0), kRoundingOfErrors);
  EXPECT_FALSE(CompareErrors(few, many, weight).AskedFor());
}

TEST(PairedErrors, NothingIsAskedForByOneUnitOrByAModelThatFails) {
  EXPECT_FALSE(CompareErrors({5.0}, {1.0}, {1.0}).AskedFor());
  EXPECT_FALSE(CompareErrors({}, {}, {}).AskedFor());
  EXPECT_FALSE(CompareErrors({5.0, 5.0}, {1.0, kInfinity}, {1.0, 1.0}).AskedFor());
  EXPECT_EQ(CompareErrors({5.0, 5.0}, {1.0, kInfinity}, {1.0, 1.0}).Probability(), 0.0);
  EXPECT_TRUE(CompareErrors({5.0, kInfinity}, {1.0, 1.0}, {1.0, 1.0}).AskedFor());
  // A unit without weight has no say, whatever its error.
  EXPECT_TRUE(CompareErrors({5.0, 5.1, 5.2, 5.3, 5.4, 0.0},
                            {1.0, 1.0, 1.0, 1.0, 1.0, kInfinity},
                            {1.0, 1.0, 1.0, 1.0, 1.0, 0.0})
                  .AskedFor());
}

// Two standard errors to one side: 2.28 % of a normal distribution lies beyond them. 27 units and
// 20,000 draws: the sampling error of the share is 0.11 %.
TEST(PairedErrors, ChanceAloneAsksAsOftenAsTwoStandardErrorsSay) {
  std::mt19937_64 engine(1);
  std::normal_distribution<double> normal;
  constexpr int kDraws = 20000;
  int asked = 0;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> simple(27);
    for (double& e : simple) e = 10.0 + normal(engine);
    const std::vector<double> rich(27, 10.0);
    if (CompareErrors(simple, rich, std::vector<double>(27, 1.0)).AskedFor()) ++asked;
  }
  EXPECT_NEAR(static_cast<double>(asked) / kDraws, 0.0228, 3.0 * 0.0011);
}

}  // namespace
}  // namespace lipoid
