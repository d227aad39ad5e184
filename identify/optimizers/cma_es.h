#pragma once

/// @file
/// Evolution strategy with adapted covariance (CMA-ES, Hansen), from pagmo. Points drawn beyond a
/// bound are put onto it.

#include "identify/optimizers/global_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct CmaEsOptions : PopulationOptions {
  CmaEsOptions() {
    population = 20;
    stall = 50;
  }
  double initial_step = 0.1;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    PopulationOptions::Visit(self, v);
    v("initial_step",
      self.initial_step,
      Range{1e-6, 10.0},
      "standard deviation of the first points, as a share of the width of the box");
  }
};

/// Every parameter needs a finite box. Defined in pagmo_adapter.cc.
[[nodiscard]] OptimizationSummary MinimizeCmaEs(const OptimizationProblem& problem,
                                                const Eigen::VectorXd& start,
                                                const CmaEsOptions& options = {},
                                                const SearchContext& context = {});

}  // namespace lipoid
