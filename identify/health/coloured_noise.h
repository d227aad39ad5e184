#pragma once

/// @file
/// Errors that are correlated in time, for least squares that know it.
///
///   e(t) = white + sum_m s_m(t),   E[s_m(t) s_m(t + h)] = sigma_m² exp(-|h|/T_m)
///
/// Each s_m is a first-order Gauss-Markov process, so a Kalman filter turns the errors of any
/// sampling into independent ones of variance 1. The filter is linear, and its gains do not depend on
/// what is filtered: the same filter takes residuals and their slopes to an ordinary least-squares
/// problem whose solution is that of generalised least squares. Tests:
/// tests/identify/health/coloured_noise_test.cc.

#include <Eigen/Core>
#include <vector>

namespace lipoid {

struct ColouredNoise {
  struct Slow {
    double deviation_V = 0.0;      ///< sigma_m
    double time_constant_s = 1.0;  ///< T_m > 0
  };

  double white_V = 0.0;  ///< standard deviation, > 0
  std::vector<Slow> slow;

  /// Each column is a quantity at these rising times; afterwards it has independent errors of
  /// variance 1. Returns the logarithm of the determinant of the covariance of the errors.
  double Whiten(const std::vector<double>& time_s, Eigen::MatrixXd& columns) const;
};

}  // namespace lipoid
