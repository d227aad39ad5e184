#pragma once

/// @file
/// When a local search ends. The same numbers mean the same for every optimizer that walks from one
/// point: interior-point, sqp, active-set, levenberg-marquardt, nelder-mead, bobyqa.

#include "model/core/options.h"

namespace lipoid {

struct LocalSearchOptions {
  /// Stop when |step| < step_tolerance * |x|, of the scaled parameters.
  double step_tolerance = 1e-6;
  /// Stop when |cost change| < function_tolerance * cost.
  double function_tolerance = 1e-12;
  int iterations_per_variable = 200;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("step_tolerance",
      self.step_tolerance,
      Range{0.0, 1.0},
      "relative size of the step, in scaled parameters, below which the search ends");
    v("function_tolerance",
      self.function_tolerance,
      Range{0.0, 1.0},
      "relative change of the cost in one step below which the search ends");
    v("iterations_per_variable",
      self.iterations_per_variable,
      Range{0.0, 1e6},
      "largest number of iterations per parameter");
  }
};

/// Of methods that need no gradient. They do not stop at a small change of the cost: points on
/// either side of a minimum have equal costs.
struct DirectSearchOptions {
  double step_tolerance = 1e-6;
  int iterations_per_variable = 200;
  double initial_step = 0.1;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("step_tolerance",
      self.step_tolerance,
      Range{0.0, 1.0},
      "relative size of the step, in scaled parameters, below which the search ends");
    v("iterations_per_variable",
      self.iterations_per_variable,
      Range{0.0, 1e6},
      "largest number of evaluations per parameter");
    v("initial_step",
      self.initial_step,
      Range{1e-9, 10.0},
      "size of the first step, relative to each scaled parameter");
  }
};

}  // namespace lipoid
