#pragma once

/// @file
/// Where in a log the residuals are large. A model that is good over most of a discharge and poor
/// near its end has residuals that say little of its middle; noise of one size all along would blame
/// the middle for the end.
///
///   s_k² = mean square of the residuals around row k over that of the log
///
/// where a residual that is the mean of n rows counts by what is expected of it: of noise from row to row an
/// n-th, of what is slower all. Else s would follow how many rows were taken together.
///
/// "Around" is within a sixteenth of the duration of the log to either side. Slow noise
/// is small or large there by chance: where the residuals change their sign n times, the quotient has the
/// power n/(n + 3). The mean of s² over the rows of the log is 1. The residuals over s are what has one correlation all along
/// (residual_correlation.h). Tests: tests/identify/trust/local_noise_test.cc.

#include <Eigen/Core>
#include <vector>

namespace lipoid {

/// Rising times; `averaged` as in FittedRows. One s > 0 per row; ones where every residual is 0.
[[nodiscard]] Eigen::VectorXd LocalNoise(const std::vector<double>& time_s,
                                         const Eigen::VectorXd& residual_V,
                                         const Eigen::VectorXd& averaged);

}  // namespace lipoid
