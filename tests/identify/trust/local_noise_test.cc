#include "identify/trust/local_noise.h"

#include <gtest/gtest.h>

#include <cmath>

#include "identify/trust/trust.h"
#include "model/statistics/normal_noise.h"

namespace lipoid {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

std::vector<double> Seconds(Index rows) {
  std::vector<double> time_s;
  for (Index k = 0; k < rows; ++k) time_s.push_back(static_cast<double>(k));
  return time_s;
}

VectorXd Noise(Index rows, std::uint64_t seed) {
  NormalNoise normal(seed, 0);
  VectorXd noise(rows);
  for (Index k = 0; k < rows; ++k) noise[k] = normal();
  return noise;
}

TEST(LocalNoise, IsOneWhereTheNoiseIsEven) {
  constexpr Index kRows = 16000;
  const VectorXd s = LocalNoise(Seconds(kRows), 1e-3 * Noise(kRows, 1), {});
  // A window has 1000 rows at the ends and 2000 elsewhere: their mean square is known to sqrt(2/1000),
  // its root to half of that; four of these.
  EXPECT_LT((s.array() - 1.0).abs().maxCoeff(), 4.0 * 0.5 * std::sqrt(2.0 / 1000.0));
  EXPECT_NEAR(s.cwiseAbs2().mean(), 1.0, 1e-12);
}

TEST(LocalNoise, FollowsANoiseThatGrowsAndWhatRowsAreTheMeanOf) {
  constexpr Index kRows = 4000;
  VectorXd residual_V = 1e-3 * Noise(kRows, 2);
  residual_V.tail(kRows / 4) *= 30.0;
  const VectorXd s = LocalNoise(Seconds(kRows), residual_V, {});
  EXPECT_NEAR(s[kRows - 1] / s[0], 30.0, 5.0);  // 250 rows each
  EXPECT_NEAR(s[kRows - 1] * std::sqrt(residual_V.cwiseAbs2().mean()), 0.03, 0.004);
  // Twice the same row is the same as one that counts twice.
  VectorXd twice(2 * kRows);
  std::vector<double> time_s;
  for (Index k = 0; k < kRows; ++k) {
    twice.segment(2 * k, 2).setConstant(residual_V[k]);
    time_s.insert(time_s.end(), 2, static_cast<double>(k));
  }
  const VectorXd by_count = LocalNoise(Seconds(kRows), residual_V, VectorXd::Constant(kRows, 2.0));
  const VectorXd by_rows = LocalNoise(time_s, twice, {});
  for (Index k = 0; k < kRows; ++k) EXPECT_NEAR(by_rows[2 * k], by_count[k], 1e-9 * by_count[k]);
}

// White noise of one size, of which many rows were taken together in some places: s does not follow them. A
// slow error of one size has it too.
TEST(LocalNoise, DoesNotFollowHowManyRowsWereTakenTogether) {
  constexpr Index kPoints = 8000;
  VectorXd count = VectorXd::Ones(kPoints);
  count.segment(kPoints / 2, kPoints / 2).setConstant(50.0);
  for (const double slow_V : {0.0, 1e-3}) {
    VectorXd residual_V = 1e-3 * Noise(kPoints, 4).cwiseQuotient(count.cwiseSqrt());
    for (Index k = 0; k < kPoints; ++k)
      residual_V[k] += slow_V * std::sin(static_cast<double>(k) / 40.0);
    const VectorXd s = LocalNoise(Seconds(kPoints), residual_V, count);
    EXPECT_NEAR(s[kPoints / 4] / s[3 * kPoints / 4], 1.0, 0.15)
        << slow_V;  // it was 7 of white noise
  }
}

// What never changes its sign is one slow error: where it is small, that is by chance.
TEST(LocalNoise, SlowNoiseKeepsOneSize) {
  VectorXd slow = VectorXd::LinSpaced(400, 1e-3, 12e-3);
  EXPECT_LT((LocalNoise(Seconds(400), slow, {}) - VectorXd::Ones(400)).norm(), 1e-12);
  for (Index k = 0; k < slow.size(); k += 2) slow[k] = -slow[k];
  EXPECT_GT(LocalNoise(Seconds(400), slow, {}).maxCoeff(), 1.3);  // the same sizes, independent
  EXPECT_EQ(LocalNoise(Seconds(3), VectorXd::Zero(3), {}), VectorXd::Ones(3));
  EXPECT_EQ(LocalNoise({}, {}, {}).size(), 0);
}

// A log of two halves, each of which knows one number: the textbook's standard error of each.
TEST(LocalNoise, WhatAQuietHalfKnowsIsNotBlamedForTheLoudOne) {
  constexpr Index kHalf = 4000;
  FittedRows rows;
  rows.time_s = Seconds(2 * kHalf);
  VectorXd noise = Noise(2 * kHalf, 3);
  noise.tail(kHalf) *= 20.0;
  rows.sensitivity.setZero(2 * kHalf, 2);
  rows.sensitivity.col(0).head(kHalf).setOnes();
  rows.sensitivity.col(1).tail(kHalf).setOnes();
  rows.weight = VectorXd::Ones(2 * kHalf);
  rows.residual_V = noise;
  rows.residual_V.head(kHalf).array() -= noise.head(kHalf).mean();
  rows.residual_V.tail(kHalf).array() -= noise.tail(kHalf).mean();
  std::vector<TrustedQuantity> quantities;
  for (Index k = 0; k < 2; ++k)
    quantities.push_back(
        {.name = k == 0 ? "quiet" : "loud", .value = 1.0, .combination = VectorXd::Unit(2, k)});
  const TrustReport report = AssessTrust({&rows, 1}, {}, quantities);
  // White noise of one size would say 14.2/sqrt(4000) of both. Windows across the border blame the
  // quiet half for some; that the noise is white has to be found too (Trust.AgreesWithTheTextbook).
  const double quiet = 1.0 / std::sqrt(static_cast<double>(kHalf));
  EXPECT_GT(report.quantities[0].standard_error / quiet, 0.85);
  EXPECT_LT(report.quantities[0].standard_error / quiet, 6.0);
  EXPECT_NEAR(report.quantities[1].standard_error / (20.0 * quiet), 1.0, 0.2);
}

}  // namespace
}  // namespace lipoid
