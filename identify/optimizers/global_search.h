#pragma once

/// @file
/// What the methods that search a whole box share: when they end, and what makes them repeatable.

#include <cstdint>

#include "model/core/options.h"

namespace lipoid {

/// The first population is the start and points drawn uniformly from the box. An iteration is a
/// generation: so many new points as the population has.
struct PopulationOptions {
  /// Stop when the population is this narrow: its extent < step_tolerance * |x|, scaled parameters.
  double step_tolerance = 1e-6;
  /// Stop when the best cost fell by less than function_tolerance * cost in `stall` iterations.
  double function_tolerance = 1e-6;
  int population = 100;
  int stall = 20;
  int iterations_per_variable = 200;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("step_tolerance",
      self.step_tolerance,
      Range{0.0, 1.0},
      "relative extent of the population, in scaled parameters, below which the search ends");
    v("function_tolerance",
      self.function_tolerance,
      Range{0.0, 1.0},
      "relative improvement below which an iteration counts as stalled");
    v("population", self.population, Range{5.0, 1e6}, "number of points in a generation");
    v("stall",
      self.stall,
      Range{1.0, 1e6},
      "number of iterations without improvement after which the search ends");
    v("iterations_per_variable",
      self.iterations_per_variable,
      Range{0.0, 1e6},
      "largest number of iterations per parameter");
  }
};

/// The same of a run: seed and threads give the same bits for any number of threads.
struct SearchContext {
  std::uint64_t seed = 0;
  int threads = 1;  ///< 0: all there are
};

}  // namespace lipoid
