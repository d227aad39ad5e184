#pragma once

/// @file
/// Differential evolution (Storn and Price; rand/1/exp), from pagmo. A parameter that would leave
/// its bounds is drawn anew within them.

#include "identify/optimizers/global_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct DifferentialEvolutionOptions : PopulationOptions {
  DifferentialEvolutionOptions() {
    population = 50;
    stall = 100;  // the start is better than most of the box for long
  }
  double weight = 0.8;
  double crossover = 0.9;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    PopulationOptions::Visit(self, v);
    v("weight", self.weight, Range{0.0, 1.0}, "weight of the difference between two points");
    v("crossover",
      self.crossover,
      Range{0.0, 1.0},
      "probability that the next parameter is taken from the mutant");
  }
};

/// Every parameter needs a finite box. Defined in pagmo_adapter.cc.
[[nodiscard]] OptimizationSummary MinimizeDifferentialEvolution(
    const OptimizationProblem& problem,
    const Eigen::VectorXd& start,
    const DifferentialEvolutionOptions& options = {},
    const SearchContext& context = {});

}  // namespace lipoid
