#pragma once

/// @file
/// Least squares whose unknowns may not be negative: variances, shares.
/// Tests: tests/model/statistics/non_negative_test.cc.

#include <Eigen/Core>

namespace lipoid {

/// min ||A x - b||, x >= 0 (Lawson and Hanson): variables enter while the slope asks for it and
/// leave where the solution would pass zero. A is m x n, b has m entries, all finite.
[[nodiscard]] Eigen::VectorXd NonNegativeLeastSquares(const Eigen::MatrixXd& a,
                                                      const Eigen::VectorXd& b);

}  // namespace lipoid
