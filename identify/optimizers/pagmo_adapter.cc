// The optimizers of pagmo behind a Monitor: the only place that knows it.
//
// Population methods evolve one generation at a time, so that the stops are ours; their state goes
// from one to the next. Every seed is given and the first population is drawn here: what pagmo
// would draw from its own source of randomness is never used.

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/algorithms/de.hpp>
#include <pagmo/algorithms/pso_gen.hpp>
#include <pagmo/algorithms/sga.hpp>
#include <pagmo/algorithms/simulated_annealing.hpp>
#include <pagmo/bfe.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <random>
#include <utility>
#include <vector>

#include "identify/optimizers/monitor.h"
#include "identify/optimizers/pagmo_methods.h"

namespace lipoid {
namespace {

using pagmo::vector_double;

// Ends an evolution from within: pagmo is C++ and lets it pass.
struct GiveUp {};

Eigen::VectorXd Point(const double* x, int size) {
  return Eigen::Map<const Eigen::VectorXd>(x, size);
}

// What pagmo copies about.
struct PagmoObjective {
  Monitor* monitor = nullptr;
  int threads = 1;

  [[nodiscard]] vector_double fitness(const vector_double& x) const {
    const double cost = monitor->Cost(Point(x.data(), monitor->size()));
    if (monitor->must_stop()) throw GiveUp();
    return {cost};
  }
  [[nodiscard]] std::pair<vector_double, vector_double> get_bounds() const {
    const auto& lower = monitor->lower();
    const auto& upper = monitor->upper();
    return {vector_double(lower.begin(), lower.end()), vector_double(upper.begin(), upper.end())};
  }
};

// A whole generation at once, by several threads.
struct Generation {
  vector_double operator()(const pagmo::problem& problem, const vector_double& points) const {
    const auto* objective = problem.extract<PagmoObjective>();
    Monitor& monitor = *objective->monitor;
    std::vector<Eigen::VectorXd> all;
    for (std::size_t k = 0; k < points.size(); k += static_cast<std::size_t>(monitor.size())) {
      all.push_back(Point(points.data() + k, monitor.size()));
    }
    vector_double costs = monitor.Costs(all, objective->threads);
    if (monitor.must_stop()) throw GiveUp();
    return costs;
  }
  template <class Archive>
  void serialize(Archive&, unsigned) {}
};

// Independent streams from one seed.
unsigned LibrarySeed(const SearchContext& context) {
  std::mt19937_64 engine(context.seed);
  return static_cast<unsigned>(engine() >> 32U);
}

// The start, and points drawn uniformly from the box: by 53 bits of the engine, since the
// distributions of the standard library differ between libraries.
std::vector<Eigen::VectorXd> FirstPoints(const Monitor& monitor,
                                         int population,
                                         const SearchContext& context) {
  std::mt19937_64 engine(context.seed);
  engine.discard(1);
  std::vector<Eigen::VectorXd> points{monitor.start()};
  while (static_cast<int>(points.size()) < population) {
    Eigen::VectorXd x(monitor.size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const double share = static_cast<double>(engine() >> 11U) * 0x1p-53;
      x[k] = monitor.lower()[k] + share * (monitor.upper()[k] - monitor.lower()[k]);
    }
    points.push_back(std::move(x));
  }
  return points;
}

pagmo::population Population(Monitor& monitor,
                             const std::vector<Eigen::VectorXd>& points,
                             const std::vector<double>& costs,
                             const SearchContext& context) {
  pagmo::population population(
      pagmo::problem(PagmoObjective{&monitor, context.threads}), 0U, LibrarySeed(context));
  for (std::size_t k = 0; k < points.size(); ++k) {
    population.push_back(vector_double(points[k].begin(), points[k].end()), {costs[k]});
  }
  return population;
}

// The whole population within step_tolerance of the best point.
bool Narrow(const pagmo::population& population, const Monitor& monitor, double step_tolerance) {
  double extent = 0.0;
  for (const auto& x : population.get_x()) {
    extent = std::max(extent, (Point(x.data(), monitor.size()) - monitor.best()).norm());
  }
  return extent <= step_tolerance * monitor.best().norm();
}

constexpr const char* kMostIterations = "The most iterations were made.";

// Evolves one generation after the other until one of our stops holds.
template <class Algorithm>
OptimizationSummary Evolve(Monitor& monitor,
                           const Algorithm& algorithm,
                           const PopulationOptions& options,
                           const SearchContext& context,
                           int most) {
  if (monitor.size() == 0 || most == 0) return *monitor.Begin(false, most);
  const auto points = FirstPoints(monitor, options.population, context);
  const auto costs = monitor.Costs(points, context.threads);
  pagmo::population population = Population(monitor, points, costs, context);
  const auto stall = static_cast<std::size_t>(options.stall);
  std::vector<double> best{monitor.best_cost()};
  try {
    while (monitor.iterations() < most && std::isfinite(monitor.best_cost())) {
      population = algorithm.evolve(std::move(population));
      monitor.CountIterations();
      if (Narrow(population, monitor, options.step_tolerance)) {
        return monitor.Finish(Termination::kConverged,
                              "The population has drawn together (step_tolerance).");
      }
      best.push_back(monitor.best_cost());
      if (best.size() <= stall) continue;
      const double gain = best[best.size() - 1 - stall] - best.back();
      if (gain <= options.function_tolerance * std::abs(best.back())) {
        return monitor.Finish(Termination::kStalled,
                              "The best cost has stopped falling (stall, function_tolerance).");
      }
    }
  } catch (const GiveUp&) {  // Finish() throws it
  }
  return monitor.Finish(Termination::kMaxIterations, kMostIterations);
}

}  // namespace

OptimizationSummary MinimizeGenetic(const OptimizationProblem& problem,
                                    const Eigen::VectorXd& start,
                                    const GeneticOptions& options,
                                    const SearchContext& context) {
  Monitor monitor(problem, start);
  PopulationOptions even = options;
  even.population += even.population % 2;  // parents come in pairs
  return Evolve(monitor,
                pagmo::sga(1U,
                           options.crossover,
                           options.crossover_index,
                           options.mutation,
                           options.mutation_width,
                           2U,
                           "sbx",
                           "gaussian",
                           "tournament",
                           LibrarySeed(context)),
                even,
                context,
                std::min(options.generations, options.iterations_per_variable * monitor.size()));
}

OptimizationSummary MinimizeParticleSwarm(const OptimizationProblem& problem,
                                          const Eigen::VectorXd& start,
                                          const ParticleSwarmOptions& options,
                                          const SearchContext& context) {
  Monitor monitor(problem, start);
  constexpr unsigned kConstricted = 5U;
  constexpr unsigned kRing = 2U;
  pagmo::pso_gen swarm(1U,
                       options.constriction,
                       options.own_attraction,
                       options.social_attraction,
                       options.maximum_velocity,
                       kConstricted,
                       kRing,
                       static_cast<unsigned>(std::min(options.neighbours, options.population - 1)),
                       true,
                       LibrarySeed(context));
  swarm.set_bfe(pagmo::bfe(Generation{}));
  return Evolve(monitor, swarm, options, context, options.iterations_per_variable * monitor.size());
}

OptimizationSummary MinimizeCmaEs(const OptimizationProblem& problem,
                                  const Eigen::VectorXd& start,
                                  const CmaEsOptions& options,
                                  const SearchContext& context) {
  Monitor monitor(problem, start);
  constexpr double kOwn = -1.0;  // the library's rule
  return Evolve(monitor,
                pagmo::cmaes(1U,
                             kOwn,
                             kOwn,
                             kOwn,
                             kOwn,
                             options.initial_step,
                             0.0,
                             0.0,
                             true,
                             true,
                             LibrarySeed(context)),
                options,
                context,
                options.iterations_per_variable * monitor.size());
}

OptimizationSummary MinimizeDifferentialEvolution(const OptimizationProblem& problem,
                                                  const Eigen::VectorXd& start,
                                                  const DifferentialEvolutionOptions& options,
                                                  const SearchContext& context) {
  Monitor monitor(problem, start);
  constexpr unsigned kRandOneExp = 2U;
  return Evolve(
      monitor,
      pagmo::de(1U, options.weight, options.crossover, kRandOneExp, 0.0, 0.0, LibrarySeed(context)),
      options,
      context,
      options.iterations_per_variable * monitor.size());
}

OptimizationSummary MinimizeSimulatedAnnealing(const OptimizationProblem& problem,
                                               const Eigen::VectorXd& start,
                                               const SimulatedAnnealingOptions& options,
                                               const SearchContext& context) {
  Monitor monitor(problem, start);
  const int most = options.iterations_per_variable * monitor.size();
  if (auto done = monitor.Begin(false, most)) return *std::move(done);
  pagmo::population population =
      Population(monitor, {monitor.start()}, {monitor.best_cost()}, context);
  constexpr double kSmallestUnit = 1e-250;  // a cost of zero has no temperature
  std::mt19937_64 seeds(context.seed);
  try {
    while (monitor.iterations() < most) {
      const Eigen::VectorXd x = monitor.best();
      const double cost = monitor.best_cost();
      const int temperatures = std::min(options.stall, most - monitor.iterations());
      const double unit = std::max(std::abs(cost), kSmallestUnit);
      const pagmo::simulated_annealing annealing(
          std::max(options.first_temperature, options.last_temperature) * unit,
          std::max(options.last_temperature * unit, std::numeric_limits<double>::min()),
          static_cast<unsigned>(temperatures),
          1U,
          static_cast<unsigned>(options.moves),
          options.range,
          static_cast<unsigned>(seeds() >> 32U));
      population = annealing.evolve(std::move(population));
      monitor.CountIterations(temperatures);
      if (cost - monitor.best_cost() <=
          options.function_tolerance * std::abs(monitor.best_cost())) {
        return monitor.Finish(Termination::kStalled,
                              "A round of cooling brought no better cost (function_tolerance).");
      }
      if ((monitor.best() - x).norm() <= options.step_tolerance * monitor.best().norm()) {
        return monitor.Finish(Termination::kConverged,
                              "A round of cooling moved the best point little (step_tolerance).");
      }
    }
  } catch (const GiveUp&) {  // Finish() throws it
  }
  return monitor.Finish(Termination::kMaxIterations, kMostIterations);
}

}  // namespace lipoid
