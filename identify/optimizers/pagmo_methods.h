#pragma once

/// @file
/// The methods of pagmo, which search a whole box: every parameter needs a finite one. Defined in
/// pagmo_adapter.cc.

#include <cstdint>

#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"
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

/// Evolution strategy with adapted covariance (CMA-ES, Hansen). Points drawn beyond a
/// bound are put onto it.
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

[[nodiscard]] OptimizationSummary MinimizeCmaEs(const OptimizationProblem& problem,
                                                const Eigen::VectorXd& start,
                                                const CmaEsOptions& options = {},
                                                const SearchContext& context = {});

/// Differential evolution (Storn and Price; rand/1/exp). A parameter that would leave
/// its bounds is drawn anew within them.
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

[[nodiscard]] OptimizationSummary MinimizeDifferentialEvolution(
    const OptimizationProblem& problem,
    const Eigen::VectorXd& start,
    const DifferentialEvolutionOptions& options = {},
    const SearchContext& context = {});

/// A genetic algorithm (sga): tournaments choose the parents, simulated binary
/// crossover (Deb) mixes them, Gaussian steps mutate the children, and the best of parents and
/// children live on.
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

[[nodiscard]] OptimizationSummary MinimizeGenetic(const OptimizationProblem& problem,
                                                  const Eigen::VectorXd& start,
                                                  const GeneticOptions& options = {},
                                                  const SearchContext& context = {});

/// Particle swarm (pso_gen): every particle is drawn to the best point it has seen and
/// to the best that its neighbours have. The thesis adapts an inertia in [0.1, 1]; pagmo has no
/// such rule, and a constant constriction factor (Clerc and Kennedy) stands in its place, from the
/// middle of that range. A particle that meets a bound stops there.
struct ParticleSwarmOptions : PopulationOptions {
  double constriction = 0.55;
  double own_attraction = 2.05;
  double social_attraction = 2.05;
  int neighbours = 50;
  double maximum_velocity = 0.5;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    PopulationOptions::Visit(self, v);
    v("constriction",
      self.constriction,
      Range{0.0, 1.0},
      "factor on the velocity, in place of an adaptive inertia");
    v("own_attraction",
      self.own_attraction,
      Range{0.0, 4.0},
      "attraction to the best point that the particle has seen");
    v("social_attraction",
      self.social_attraction,
      Range{0.0, 4.0},
      "attraction to the best point that its neighbours have seen");
    v("neighbours",
      self.neighbours,
      Range{2.0, 1e6},
      "number of neighbours of a particle on a ring");
    v("maximum_velocity",
      self.maximum_velocity,
      Range{1e-6, 1.0},
      "largest velocity, as a share of the width of the box per iteration");
  }
};

[[nodiscard]] OptimizationSummary MinimizeParticleSwarm(const OptimizationProblem& problem,
                                                        const Eigen::VectorXd& start,
                                                        const ParticleSwarmOptions& options = {},
                                                        const SearchContext& context = {});

/// Simulated annealing after Corana: one parameter at a time takes a random step, whose
/// range adapts until half of the steps are accepted.
///
/// An iteration is one temperature. The library follows its schedule from beginning to end, so the
/// search is made of rounds: each cools over as many temperatures as may stall, from the best point
/// so far, and the last is the one that brought no improvement. Temperatures are relative to the
/// best cost at the beginning of a round: at 1, doubling the cost is accepted with probability 1/e.
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

[[nodiscard]] OptimizationSummary MinimizeSimulatedAnnealing(
    const OptimizationProblem& problem,
    const Eigen::VectorXd& start,
    const SimulatedAnnealingOptions& options = {},
    const SearchContext& context = {});

}  // namespace lipoid
