#pragma once

/// @file
/// Simulated annealing after Corana, from pagmo: one parameter at a time takes a random step, whose
/// range adapts until half of the steps are accepted.
///
/// An iteration is one temperature. The library follows its schedule from beginning to end, so the
/// search is made of rounds: each cools over as many temperatures as may stall, from the best point
/// so far, and the last is the one that brought no improvement. Temperatures are relative to the
/// best cost at the beginning of a round: at 1, doubling the cost is accepted with probability 1/e.

#include "identify/optimizers/global_search.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

struct SimulatedAnnealingOptions {
  /// Stop when a round moved the best point by less than step_tolerance * |x|.
  double step_tolerance = 1e-6;
  /// Stop when a round lowered the best cost by less than function_tolerance * cost.
  double function_tolerance = 1e-6;
  int stall = 20;
  int iterations_per_variable = 200;
  int moves = 50;
  double first_temperature = 0.1;
  double last_temperature = 1e-6;
  double range = 1.0;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("step_tolerance",
      self.step_tolerance,
      Range{0.0, 1.0},
      "relative move of the best point in a round, in scaled parameters, below which the search "
      "ends");
    v("function_tolerance",
      self.function_tolerance,
      Range{0.0, 1.0},
      "relative improvement below which a round counts as stalled");
    v("stall", self.stall, Range{1.0, 1e6}, "number of temperatures in a round of cooling");
    v("iterations_per_variable",
      self.iterations_per_variable,
      Range{0.0, 1e6},
      "largest number of temperatures per parameter");
    v("moves", self.moves, Range{1.0, 1e6}, "number of steps of each parameter at a temperature");
    v("first_temperature",
      self.first_temperature,
      Range{1e-300, 1e300},
      "temperature at the beginning of a round, relative to the best cost");
    v("last_temperature",
      self.last_temperature,
      Range{1e-300, 1e300},
      "temperature at the end of a round, relative to the best cost; at most the first");
    v("range",
      self.range,
      Range{1e-9, 1.0},
      "first range of the steps, as a share of the width of the box");
  }
};

/// Every parameter needs a finite box. Defined in pagmo_adapter.cc.
[[nodiscard]] OptimizationSummary MinimizeSimulatedAnnealing(
    const OptimizationProblem& problem,
    const Eigen::VectorXd& start,
    const SimulatedAnnealingOptions& options = {},
    const SearchContext& context = {});

}  // namespace lipoid
