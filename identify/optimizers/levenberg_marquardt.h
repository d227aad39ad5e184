#pragma once

/// @file
/// Levenberg-Marquardt with bounds, from Ceres. The default solver of stage 3.
///
/// A parameter that reaches a bound is held there while the others converge, and let go where the
/// slope then leads back inside: the answer satisfies the conditions of Karush, Kuhn and Tucker.
/// One evaluation per step, of value and Jacobian together. A start outside the bounds is moved
/// onto them; one without a finite value is a kFailure with the cost NaN. Tests:
/// tests/identify/optimizers/levenberg_marquardt_test.cc.

#include "identify/optimizers/least_squares.h"
#include "identify/optimizers/local_search.h"
#include "model/core/options.h"

namespace lipoid {

struct LevenbergMarquardtOptions {
  /// Stop when |cost change| < function_tolerance * cost.
  double function_tolerance = 1e-12;
  /// Stop when |step| < step_tolerance * (|x| + step_tolerance), of the scaled parameters.
  double step_tolerance = 1e-10;
  /// Stop when the largest component of J'r, of the free parameters, is below this.
  double gradient_tolerance = 1e-16;
  /// Accepted and rejected steps together.
  int max_iterations = 200;

  /// With the stopping rules that all local searches share, for a problem of so many parameters.
  [[nodiscard]] static LevenbergMarquardtOptions From(const LocalSearchOptions& stop, int size) {
    return {.function_tolerance = stop.function_tolerance,
            .step_tolerance = stop.step_tolerance,
            .max_iterations = stop.iterations_per_variable * size};
  }

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("function_tolerance",
      self.function_tolerance,
      Range{0.0, 1.0},
      "relative change of the cost below which the search ends");
    v("step_tolerance",
      self.step_tolerance,
      Range{0.0, 1.0},
      "relative size of the step below which the search ends");
    v("gradient_tolerance",
      self.gradient_tolerance,
      Range{0.0, 1.0},
      "largest component of the gradient below which the search ends");
    v("max_iterations",
      self.max_iterations,
      Range{1.0, 1e6},
      "largest number of steps, accepted and rejected");
  }
};

[[nodiscard]] OptimizationSummary MinimizeLevenbergMarquardt(
    const LeastSquaresProblem& problem,
    const Eigen::VectorXd& start,
    const LevenbergMarquardtOptions& options = {});

}  // namespace lipoid
