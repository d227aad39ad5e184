#include "model/control/altitude_filter.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <complex>
#include <limits>

#include "model/statistics/normal_noise.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

constexpr double kAltitudeQ_m2_per_s2 = 5e-4;
constexpr double kR_m2 = 0.1;
using test::kFlightStep_s;
constexpr double kNoGate = std::numeric_limits<double>::infinity();

AltitudeFilter Steady() {
  AltitudeFilter filter(kAltitudeQ_m2_per_s2, kR_m2, kFlightStep_s);
  for (int k = 0; k < 4000; ++k) {
    filter.Predict(0.0);
    filter.Update(0.0, kNoGate);
  }
  return filter;
}

Eigen::Matrix2d Transition() {
  return (Eigen::Matrix2d() << 1.0, kFlightStep_s, 0.0, 1.0).finished();
}

// The stabilizing solution of the algebraic Riccati equation of the filter, from the stable
// eigenvectors of its symplectic matrix: nothing is iterated.
Eigen::Matrix2d RiccatiSolution() {
  const Eigen::Matrix2d a = Transition().transpose();
  const Eigen::Vector2d b(1.0, 0.0);
  const Eigen::Matrix2d q = Eigen::Vector2d(0.0, kAltitudeQ_m2_per_s2).asDiagonal();
  const Eigen::Matrix2d inverse = a.transpose().inverse();
  const Eigen::Matrix2d g = b * b.transpose() / kR_m2;
  Eigen::Matrix4d symplectic;
  symplectic << a + g * inverse * q, -g * inverse, -inverse * q, inverse;
  const Eigen::EigenSolver<Eigen::Matrix4d> solver(symplectic);
  Eigen::Matrix<std::complex<double>, 4, 2> stable;
  int found = 0;
  for (int k = 0; k < 4; ++k) {
    if (std::abs(solver.eigenvalues()[k]) < 1.0 && found < 2) {
      stable.col(found++) = solver.eigenvectors().col(k);
    }
  }
  EXPECT_EQ(found, 2);
  return (stable.bottomRows<2>() * stable.topRows<2>().inverse()).real();
}

TEST(AltitudeFilter, ReachesTheSolutionOfTheRiccatiEquation) {
  const Eigen::Matrix2d before = RiccatiSolution();
  const Eigen::Vector2d gain = before.col(0) / (before(0, 0) + kR_m2);
  const Eigen::Matrix2d after = before - gain * before.row(0);  // the covariance after an update
  // The four eigenvalues lie within 0.02 of 1: they and so the solution lose some digits.
  constexpr double kRelative = 1e-9;
  const AltitudeFilter filter = Steady();
  EXPECT_NEAR(filter.covariance().zz, after(0, 0), kRelative * after(0, 0));
  EXPECT_NEAR(filter.covariance().zw, after(0, 1), kRelative * after(0, 1));
  EXPECT_NEAR(filter.covariance().ww, after(1, 1), kRelative * after(1, 1));

  // The gains that the next reading gets, and the figures that estimator.h gives for them.
  AltitudeFilter next = filter;
  next.Predict(0.0);
  next.Update(1.0, kNoGate);
  EXPECT_NEAR(next.down_m(), gain[0], kRelative * gain[0]);
  EXPECT_NEAR(next.rate_m_per_s(), gain[1], kRelative * gain[1]);
  EXPECT_NEAR(gain[0], 0.0262, 5e-5);
  EXPECT_NEAR(gain[1], 0.0698, 5e-5);
  const Eigen::Matrix2d loop =
      (Eigen::Matrix2d::Identity() - gain * Eigen::RowVector2d(1.0, 0.0)) * Transition();
  const std::complex<double> pole = std::log(loop.eigenvalues()[0]) / kFlightStep_s;
  EXPECT_NEAR(std::abs(pole), 3.8, 0.05);
  EXPECT_NEAR(-pole.real() / std::abs(pole), 0.71, 0.005);
}

// Where the noise is what Q and R say, the errors are what the covariance says.
TEST(AltitudeFilter, ErrsAsItsCovarianceSays) {
  constexpr int kRuns = 4000;
  NormalNoise noise(1, 1);
  double normalized = 0.0;
  for (int run = 0; run < kRuns; ++run) {
    AltitudeFilter filter(kAltitudeQ_m2_per_s2, kR_m2, kFlightStep_s);
    double z = 0.0;
    double w = 0.0;
    for (int k = 0; k < 200; ++k) {
      const double acceleration = std::sin(0.1 * k);
      z += kFlightStep_s * (w + 0.5 * kFlightStep_s * acceleration);
      w += kFlightStep_s * acceleration + std::sqrt(kAltitudeQ_m2_per_s2) * noise();
      filter.Predict(acceleration);
      filter.Update(z + std::sqrt(kR_m2) * noise(), kNoGate);
    }
    const auto& p = filter.covariance();
    const Eigen::Vector2d error(filter.down_m() - z, filter.rate_m_per_s() - w);
    const Eigen::Matrix2d covariance = (Eigen::Matrix2d() << p.zz, p.zw, p.zw, p.ww).finished();
    normalized += error.dot(covariance.inverse() * error);
  }
  // Chi-squared of two degrees each: mean 2, variance 4. Four sigma.
  EXPECT_NEAR(normalized / kRuns, 2.0, 4.0 * 2.0 / std::sqrt(kRuns));
}

TEST(AltitudeFilter, FollowsAKnownAcceleration) {
  AltitudeFilter filter(kAltitudeQ_m2_per_s2, kR_m2, kFlightStep_s);
  filter.Reset(-1.0, 0.5);
  for (int k = 1; k <= 400; ++k) {
    filter.Predict(3.0);
    const double t_s = k * kFlightStep_s;
    filter.Update(-1.0 + 0.5 * t_s + 1.5 * t_s * t_s, kNoGate);
  }
  constexpr double kRounding = 1e-12;  // 400 sums of numbers below 10
  EXPECT_NEAR(filter.down_m(), -1.0 + 1.0 + 6.0, kRounding);
  EXPECT_NEAR(filter.rate_m_per_s(), 6.5, kRounding);
}

TEST(AltitudeFilter, RefusesWhatIsBeyondTheGateOrNoNumber) {
  AltitudeFilter filter = Steady();
  const auto before = filter;
  for (const double reading : {0.31,
                               -0.31,
                               std::numeric_limits<double>::quiet_NaN(),
                               std::numeric_limits<double>::infinity()}) {
    EXPECT_FALSE(filter.Update(reading, 0.3));
    EXPECT_EQ(filter.down_m(), before.down_m());
    EXPECT_EQ(filter.rate_m_per_s(), before.rate_m_per_s());
    EXPECT_EQ(filter.covariance().zz, before.covariance().zz);
  }
  EXPECT_TRUE(filter.Update(0.29, 0.3));
  EXPECT_GT(filter.down_m(), 0.0);
}

TEST(AltitudeFilter, TrustsReadingsMoreAfterATimeWithout) {
  AltitudeFilter filter = Steady();
  for (int k = 0; k < 200; ++k) filter.Predict(0.0);
  EXPECT_GT(filter.covariance().zz, 0.01);
  filter.Restart(2.0);
  EXPECT_EQ(filter.down_m(), 2.0);
  EXPECT_EQ(filter.covariance().zz, kR_m2);
  EXPECT_EQ(filter.covariance().zw, 0.0);
}

}  // namespace
}  // namespace lipoid
