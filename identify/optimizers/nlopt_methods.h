#pragma once

/// @file
/// The methods of NLopt, one row each. To add one: a name here, its row in nlopt_methods.cc and its
/// row in optimizers.cc. The only place that knows NLopt.
///
/// NLopt does not tell its iterations. With gradients every evaluation of one is counted as an
/// iteration, without them every evaluation; the limit on iterations is ours, the tolerances are
/// the library's. Where the cost has no value NLopt is told a huge one.

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

enum class NloptMethod {
  /// Sequential quadratic programming, SLSQP of Dieter Kraft: a BFGS matrix of the Lagrangian and a
  /// quadratic program with the bounds in each step.
  kSequentialQuadratic,
  /// A quasi-Newton method with an active set of bounds, the limited-memory BFGS of Ladislav
  /// Luksan. A parameter that reaches a bound joins the set and is held; the one with the steepest
  /// slope back inside leaves it when the others have little slope left. Why this one:
  /// docs/optimizers.md.
  kActiveSet,
  /// The simplex of Nelder and Mead. Points beyond a bound are put onto it (Box).
  kNelderMead,
  /// BOBYQA of Michael Powell: a trust region on a quadratic model that interpolates 2n+1 points
  /// within the bounds.
  kBobyqa,
};

/// Of methods with gradients, which the problem must have.
[[nodiscard]] OptimizationSummary MinimizeWithNlopt(NloptMethod method,
                                                    const OptimizationProblem& problem,
                                                    const Eigen::VectorXd& start,
                                                    const LocalSearchOptions& options = {});

/// Of methods without.
[[nodiscard]] OptimizationSummary MinimizeWithNlopt(NloptMethod method,
                                                    const OptimizationProblem& problem,
                                                    const Eigen::VectorXd& start,
                                                    const DirectSearchOptions& options = {});

}  // namespace lipoid
