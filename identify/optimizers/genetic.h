#pragma once

/// @file
/// A genetic algorithm, from pagmo (sga): tournaments choose the parents, simulated binary
/// crossover (Deb) mixes them, Gaussian steps mutate the children, and the best of parents and
/// children live on.

#include "identify/optimizers/global_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct GeneticOptions : PopulationOptions {
  int generations = 1000;
  double crossover = 0.9;
  double crossover_index = 1.0;
  double mutation = 0.5;
  double mutation_width = 0.0005;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    PopulationOptions::Visit(self, v);
    v("generations",
      self.generations,
      Range{0.0, 1e6},
      "largest number of generations, besides iterations_per_variable");
    v("crossover", self.crossover, Range{0.0, 1.0}, "probability that two parents are mixed");
    v("crossover_index",
      self.crossover_index,
      Range{1.0, 100.0},
      "distribution index of the crossover: children lie the nearer to their parents the larger it "
      "is");
    v("mutation", self.mutation, Range{0.0, 1.0}, "probability that a parameter is changed");
    v("mutation_width",
      self.mutation_width,
      Range{0.0, 1.0},
      "standard deviation of the change, as a share of the width of the box");
  }
};

/// Every parameter needs a finite box. Defined in pagmo_adapter.cc.
[[nodiscard]] OptimizationSummary MinimizeGenetic(const OptimizationProblem& problem,
                                                  const Eigen::VectorXd& start,
                                                  const GeneticOptions& options = {},
                                                  const SearchContext& context = {});

}  // namespace lipoid
