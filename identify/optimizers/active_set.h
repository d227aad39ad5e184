#pragma once

/// @file
/// A quasi-Newton method with an active set of bounds, from NLopt: the limited-memory BFGS of
/// Ladislav Luksan. A parameter that reaches a bound joins the set and is held; the one with the
/// steepest slope back inside leaves it when the others have little slope left. Why this one:
/// docs/optimizers.md.

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

/// The problem must have a gradient.
[[nodiscard]] OptimizationSummary MinimizeActiveSet(const OptimizationProblem& problem,
                                                    const Eigen::VectorXd& start,
                                                    const LocalSearchOptions& options = {});

}  // namespace lipoid
