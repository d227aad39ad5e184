#pragma once

/// @file
/// Sequential quadratic programming, from NLopt: SLSQP of Dieter Kraft, a BFGS matrix of the
/// Lagrangian and a quadratic program with the bounds in each step.

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

/// The problem must have a gradient.
[[nodiscard]] OptimizationSummary MinimizeSqp(const OptimizationProblem& problem,
                                              const Eigen::VectorXd& start,
                                              const LocalSearchOptions& options = {});

}  // namespace lipoid
