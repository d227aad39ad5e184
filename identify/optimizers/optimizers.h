#pragma once

/// @file
/// The only list of optimizers: help, messages, docs and tests are made from it. The order is that
/// of Table 4.4 of the thesis, then what it did not try. docs/optimizers.md compares them.
///
///   const OptimizerEntry& optimizer = FindOptimizer("sqp");
///   const OptimizationSummary summary = optimizer.Minimize(problem, start, settings);

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/optimizers/interior_point.h"
#include "identify/optimizers/local_search.h"
#include "identify/optimizers/pagmo_methods.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"
#include "model/core/options.h"

namespace lipoid {

/// The options of all optimizers, with the thesis' defaults.
struct OptimizerSettings {
  SearchContext context;
  InteriorPointOptions interior_point;
  LocalSearchOptions sqp;
  LocalSearchOptions active_set;
  LocalSearchOptions levenberg_marquardt;
  GeneticOptions genetic;
  ParticleSwarmOptions particle_swarm;
  SimulatedAnnealingOptions simulated_annealing;
  CmaEsOptions cma_es;
  DifferentialEvolutionOptions differential_evolution;
  DirectSearchOptions nelder_mead;
  DirectSearchOptions bobyqa;
};

struct OptimizerEntry {
  std::string_view name;
  std::string_view library;
  std::string_view summary;

  bool in_thesis = false;            ///< a row of Table 4.4
  bool needs_least_squares = false;  ///< a LeastSquaresProblem
  bool needs_gradient = false;
  bool needs_box = false;  ///< every parameter has two finite bounds, or equal ones
  bool global = false;     ///< searches the whole box, from settings.context.seed

  std::vector<OptionDescription> (*options)() = nullptr;
  void (*set)(OptimizerSettings&, std::string_view option, std::string_view text) = nullptr;
  std::vector<std::pair<std::string, std::string>> (*values)(const OptimizerSettings&) = nullptr;

  OptimizationSummary (*run)(const OptimizationProblem&,
                             const Eigen::VectorXd& start,
                             const OptimizerSettings&) = nullptr;

  /// Throws nothing for what the problem does, save std::bad_alloc. A problem that lacks what is
  /// needed is a kFailure whose message says so.
  [[nodiscard]] OptimizationSummary Minimize(const OptimizationProblem& problem,
                                             const Eigen::VectorXd& start,
                                             const OptimizerSettings& settings = {}) const;

  /// Why what it found is no answer, and what to do; "" where it ended as it should: by a tolerance
  /// or, as a global search does, when its iterations were used up.
  [[nodiscard]] std::string WhyNoAnswer(const OptimizationSummary& found) const;
};

[[nodiscard]] const std::vector<OptimizerEntry>& Optimizers();

/// Throws OptionError naming all optimizers.
[[nodiscard]] const OptimizerEntry& FindOptimizer(std::string_view name);

}  // namespace lipoid
