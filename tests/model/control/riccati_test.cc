#include "model/control/riccati.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "tests/support/ridders.h"

namespace lipoid {
namespace {

// The answer put back into its equation, and the loop that it closes.
void ExpectRegulator(const Eigen::MatrixXd& a,
                     const Eigen::MatrixXd& b,
                     const Eigen::MatrixXd& q,
                     const Eigen::MatrixXd& r) {
  const auto p = SolveRiccati(a, b, q, r);
  ASSERT_TRUE(p.has_value());
  const Eigen::MatrixXd gain = r.inverse() * b.transpose() * *p;
  const Eigen::MatrixXd residual = a.transpose() * *p + *p * a - p->transpose() * b * gain + q;
  constexpr double kRounding = 1e-11;  // of the terms of the equation
  EXPECT_LT(residual.norm(), kRounding * (a.norm() * p->norm() + q.norm())) << residual;
  const Eigen::EigenSolver<Eigen::MatrixXd> closed(a - b * gain, false);
  EXPECT_LT(closed.eigenvalues().real().maxCoeff(), 0.0);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> definite(*p);
  EXPECT_GE(definite.eigenvalues().minCoeff(), -kRounding * p->norm());
}

TEST(Riccati, TheAnswerSolvesItsEquationAndIsStable) {
  Eigen::Matrix3d chain = Eigen::Matrix3d::Zero();
  chain(0, 1) = chain(1, 2) = 1.0;
  ExpectRegulator(chain,
                  Eigen::Vector3d(0.0, 0.0, -1.0),
                  Eigen::Vector3d(2.0, 0.5, 0.1).asDiagonal(),
                  Eigen::MatrixXd::Constant(1, 1, 0.3));
  // An unstable plant with two inputs.
  Eigen::Matrix4d a;
  a << 0.3, 1.0, 0.0, 0.2, -0.5, 0.1, 1.0, 0.0, 0.0, 0.4, -0.2, 1.0, 0.1, 0.0, 0.6, 0.5;
  Eigen::MatrixXd b(4, 2);
  b << 0.0, 1.0, 1.0, 0.0, 0.0, 0.3, 0.7, 0.0;
  Eigen::Matrix2d r;
  r << 2.0, 0.3, 0.3, 1.0;
  ExpectRegulator(a, b, Eigen::Matrix4d::Identity(), r);
}

TEST(Riccati, HasTheClosedFormOfADoubleIntegrator) {
  Eigen::Matrix2d a = Eigen::Matrix2d::Zero();
  a(0, 1) = 1.0;
  const auto p = SolveRiccati(a,
                              Eigen::Vector2d(0.0, 1.0),
                              Eigen::Vector2d(1.0, 0.0).asDiagonal(),
                              Eigen::MatrixXd::Identity(1, 1));
  ASSERT_TRUE(p.has_value());
  EXPECT_NEAR((*p)(0, 0), std::sqrt(2.0), 1e-13);
  EXPECT_NEAR((*p)(0, 1), 1.0, 1e-13);
  EXPECT_NEAR((*p)(1, 1), std::sqrt(2.0), 1e-13);
}

TEST(Riccati, SaysWhereNothingCanBeStabilised) {
  Eigen::Matrix2d a = Eigen::Matrix2d::Identity();
  EXPECT_FALSE(SolveRiccati(a,
                            Eigen::Vector2d(0.0, 1.0),
                            Eigen::Matrix2d::Identity(),
                            Eigen::MatrixXd::Identity(1, 1))
                   .has_value());
}

TEST(Riccati, TheRegulatorOfAnAxisFactorsItsSpectrum) {
  // |s³ + K_edot s² + K_e s + K_eI|² at s = i w is w⁶ + w_d² w⁴ + w_e² w² + w_I².
  for (const RegulatorWeights& weights : {RegulatorWeights{0.0, 8.0, 0.0},
                                          RegulatorWeights{3.0, 0.01, 2.0},
                                          RegulatorWeights{40.0, 200.0, 0.5}}) {
    const ErrorGains gains = AxisRegulator(weights).gains;
    for (const double w : {0.01, 0.5, 3.0, 20.0}) {
      const double even = gains.integral - gains.derivative * w * w;
      const double odd = gains.proportional * w - w * w * w;
      const double spectrum = std::pow(w, 6) + std::pow(weights.rate_per_s * w * w, 2) +
                              std::pow(weights.error_per_s2 * w, 2) +
                              std::pow(weights.integral_per_s3, 2);
      constexpr double kRounding = 1e-9;
      EXPECT_NEAR(even * even + odd * odd, spectrum, kRounding * spectrum) << w;
    }
    EXPECT_GT(gains.derivative * gains.proportional, gains.integral);  // Routh
  }
  // Without weights on error and rate it is Butterworth's polynomial.
  const ErrorGains butterworth = AxisRegulator({0.0, 8.0, 0.0}).gains;
  EXPECT_NEAR(butterworth.proportional, 8.0, 1e-9);
  EXPECT_NEAR(butterworth.derivative, 4.0, 1e-9);
}

TEST(Riccati, TheSlopesOfARegulatorAreThoseOfItsDifferences) {
  const RegulatorWeights at{3.0, 2.0, 1.5};
  const RegulatorGains regulator = AxisRegulator(at);
  // d/d(w²) = 1/(2 w) d/dw
  const auto expect_slopes = [&](double RegulatorWeights::*weight,
                                 const ErrorGains& slopes,
                                 double power) {
    for (double ErrorGains::*gain :
         {&ErrorGains::proportional, &ErrorGains::integral, &ErrorGains::derivative}) {
      const auto along = [&](double value) {
        RegulatorWeights moved = at;
        moved.*weight = value;
        return AxisRegulator(moved).gains.*gain;
      };
      const double per_weight = test::Ridders(along, at.*weight, 0.1).value;
      EXPECT_NEAR(slopes.*gain, power == 2.0 ? per_weight / (2.0 * at.*weight) : per_weight, 1e-8);
    }
  };
  expect_slopes(&RegulatorWeights::error_per_s2, regulator.per_error, 2.0);
  expect_slopes(&RegulatorWeights::integral_per_s3, regulator.per_integral, 1.0);
  expect_slopes(&RegulatorWeights::rate_per_s, regulator.per_rate, 2.0);
}

}  // namespace
}  // namespace lipoid
