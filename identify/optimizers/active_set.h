#pragma once

/// @file
/// A quasi-Newton method with an active set of bounds, from NLopt: VAR2 of Ladislav Luksan, a
/// shifted limited-memory variable metric of rank two. A parameter that reaches a bound joins the
/// set and is held; the one with the steepest slope back inside leaves it when the others have
/// little slope left. That is the method of an active set; of NLopt's others, MMA and CCSAQ bound
/// a convex model instead, and LBFGS and TNEWTON share VAR2's active set: docs/optimizers.md.

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

/// The problem must have a gradient.
[[nodiscard]] OptimizationSummary MinimizeActiveSet(const OptimizationProblem& problem,
                                                    const Eigen::VectorXd& start,
                                                    const LocalSearchOptions& options = {});

}  // namespace lipoid
