#pragma once

/// @file
/// BOBYQA of Michael Powell, from NLopt: a trust region on a quadratic model that interpolates
/// 2n+1 points within the bounds. It needs no gradient.

#include "identify/optimizers/local_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

[[nodiscard]] OptimizationSummary MinimizeBobyqa(const OptimizationProblem& problem,
                                                 const Eigen::VectorXd& start,
                                                 const DirectSearchOptions& options = {});

}  // namespace lipoid
