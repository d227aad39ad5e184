#pragma once

/// @file
/// The simplex of Nelder and Mead, from NLopt, which puts points beyond a bound onto it (Box). It
/// needs no gradient.

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

[[nodiscard]] OptimizationSummary MinimizeNelderMead(const OptimizationProblem& problem,
                                                     const Eigen::VectorXd& start,
                                                     const DirectSearchOptions& options = {});

}  // namespace lipoid
