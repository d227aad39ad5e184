#pragma once

/// @file
/// Levenberg-Marquardt with bounds, from Ceres. The default solver of stage 3.
/// Tests: tests/identify/optimizers/levenberg_marquardt_test.cc.

#include "identify/optimizers/least_squares.h"
#include "model/core/options.h"

namespace lipoid {

struct LevenbergMarquardtOptions {
  /// Stop when |cost change| < function_tolerance * cost.
  double function_tolerance = 1e-12;
  /// Stop when |step| < step_tolerance * (|x| + step_tolerance), of the scaled parameters.
  double step_tolerance = 1e-10;
  /// Stop when the largest component of the projected gradient, over the largest at the start, is below this.
  double gradient_tolerance = 1e-16;
  int max_iterations = 200;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("function_tolerance", self.function_tolerance, Range{0.0, 1.0}, "relative change of the cost");
    v("step_tolerance", self.step_tolerance, Range{0.0, 1.0}, "relative size of the step");
    v("gradient_tolerance", self.gradient_tolerance, Range{0.0, 1.0}, "size of the projected gradient");
    v("max_iterations", self.max_iterations, Range{1.0, 1e6}, "accepted and rejected steps");
  }
};

[[nodiscard]] LeastSquaresSummary MinimizeLevenbergMarquardt(const LeastSquaresProblem& problem,
                                                             const Eigen::VectorXd& start,
                                                             const LevenbergMarquardtOptions& options = {});

}  // namespace lipoid
