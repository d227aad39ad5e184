#include "identify/health/coloured_noise.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

namespace lipoid {
namespace {

// The covariance written out, and its Cholesky factor: S = L L', whitened = L^-1 columns.
TEST(ColouredNoise, WhitensAsTheCholeskyFactorOfTheCovarianceDoes) {
  const ColouredNoise noise{0.01, {{0.02, 3.0}, {0.005, 40.0}}};
  const std::vector<double> time_s{0.0, 0.2, 0.4, 1.7, 2.0, 9.0, 30.0, 30.1, 55.0};
  const auto n = static_cast<Eigen::Index>(time_s.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const double apart_s =
          std::abs(time_s[static_cast<std::size_t>(a)] - time_s[static_cast<std::size_t>(b)]);
      covariance(a, b) = 4e-4 * std::exp(-apart_s / 3.0) + 25e-6 * std::exp(-apart_s / 40.0) +
                         (a == b ? 1e-4 : 0.0);
    }
  }
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  Eigen::MatrixXd columns(n, 3);
  for (double& value : columns.reshaped()) value = normal(engine);
  const Eigen::LLT<Eigen::MatrixXd> factor(covariance);
  const Eigen::MatrixXd expected = factor.matrixL().solve(columns);
  const double determinant = 2.0 * factor.matrixLLT().diagonal().array().log().sum();
  const double found = noise.Whiten(time_s, columns);
  constexpr double kRounding = 1e-9;  // of values up to 1e2, through a covariance of condition 1e3
  EXPECT_LT((columns - expected).cwiseAbs().maxCoeff(), kRounding);
  EXPECT_NEAR(found, determinant, kRounding);
}

TEST(ColouredNoise, WhiteAloneIsDivided) {
  const ColouredNoise noise{0.5, {}};
  Eigen::MatrixXd columns(3, 1);
  columns << 1.0, -2.0, 3.0;
  EXPECT_NEAR(noise.Whiten({0.0, 1.0, 2.0}, columns), 3.0 * std::log(0.25), 1e-15);
  EXPECT_DOUBLE_EQ(columns(1, 0), -4.0);
}

}  // namespace
}  // namespace lipoid
