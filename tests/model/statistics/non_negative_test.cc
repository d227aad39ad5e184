// Against the conditions that the one minimum of a convex problem meets, and no other point does.
#include "model/statistics/non_negative.h"

#include <gtest/gtest.h>

#include "model/statistics/normal_noise.h"

namespace lipoid {
namespace {

TEST(NonNegativeLeastSquares, MeetsTheConditionsOfTheMinimum) {
  NormalNoise noise(7, 0);
  int at_zero = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Eigen::Index n = 1 + trial % 8;
    Eigen::MatrixXd a(n + 4, n);
    Eigen::VectorXd b(n + 4);
    for (double& x : a.reshaped()) x = noise();
    for (double& x : b) x = noise();
    const Eigen::VectorXd x = NonNegativeLeastSquares(a, b);
    const Eigen::VectorXd slope = a.transpose() * (a * x - b);
    // Where x > 0 the slope vanishes; where x = 0 it points inwards. Rounding of n sums of ten.
    constexpr double kRounding = 1e-10;
    for (Eigen::Index k = 0; k < n; ++k) {
      EXPECT_GE(x[k], 0.0);
      EXPECT_GE(slope[k], -kRounding) << trial;
      EXPECT_LE(x[k] * slope[k], kRounding) << trial;
      if (x[k] == 0.0) ++at_zero;
    }
  }
  EXPECT_GT(at_zero, 100) << "the bounds were met";
}

TEST(NonNegativeLeastSquares, IsThePlainSolutionWhereThatIsPositive) {
  const Eigen::Matrix2d a{{2.0, 1.0}, {1.0, 3.0}};
  const Eigen::Vector2d x = NonNegativeLeastSquares(a, Eigen::Vector2d(4.0, 7.0));
  EXPECT_NEAR(x[0], 1.0, 1e-14);
  EXPECT_NEAR(x[1], 2.0, 1e-14);
  EXPECT_TRUE(NonNegativeLeastSquares(a, Eigen::Vector2d(-1.0, -1.0)).isZero());
}

}  // namespace
}  // namespace lipoid
