#include "identify/optimizers/optimizers.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <type_traits>

#include "identify/optimizers/least_squares.h"
#include "identify/optimizers/levenberg_marquardt.h"
#include "identify/optimizers/nlopt_methods.h"
#include "model/core/nearest_name.h"

namespace lipoid {
namespace {

// The columns of the table that follow from where the options are kept.
template <auto kMember>
OptimizerEntry Entry(OptimizerEntry entry) {
  using Options = std::remove_cvref_t<decltype(OptimizerSettings{}.*kMember)>;
  entry.options = &DescribeOptions<Options>;
  entry.set = [](OptimizerSettings& settings, std::string_view option, std::string_view text) {
    SetOption(settings.*kMember, option, text);
  };
  entry.values = [](const OptimizerSettings& settings) { return OptionValues(settings.*kMember); };
  return entry;
}

template <auto kMember, auto kMinimize>
OptimizationSummary Call(const OptimizationProblem& problem,
                         const Eigen::VectorXd& start,
                         const OptimizerSettings& settings) {
  return kMinimize(problem, start, settings.*kMember);
}

template <auto kMember, NloptMethod kMethod>
OptimizationSummary Nlopt(const OptimizationProblem& problem,
                          const Eigen::VectorXd& start,
                          const OptimizerSettings& settings) {
  return MinimizeWithNlopt(kMethod, problem, start, settings.*kMember);
}

// Of methods that search a box.
template <auto kMember, auto kMinimize>
OptimizationSummary Search(const OptimizationProblem& problem,
                           const Eigen::VectorXd& start,
                           const OptimizerSettings& settings) {
  return kMinimize(problem, start, settings.*kMember, settings.context);
}

OptimizationSummary LevenbergMarquardt(const OptimizationProblem& problem,
                                       const Eigen::VectorXd& start,
                                       const OptimizerSettings& settings) {
  return MinimizeLevenbergMarquardt(
      dynamic_cast<const LeastSquaresProblem&>(problem),
      start,
      LevenbergMarquardtOptions::From(settings.levenberg_marquardt, problem.size()));
}

bool HasBox(const OptimizationProblem& problem) {
  const Eigen::VectorXd lower = problem.lower();
  const Eigen::VectorXd upper = problem.upper();
  return std::all_of(lower.begin(), lower.end(), &IsBound) &&
         std::all_of(upper.begin(), upper.end(), &IsBound);
}

}  // namespace

const std::vector<OptimizerEntry>& Optimizers() {
  using S = OptimizerSettings;
  static const std::vector<OptimizerEntry> table = {
      Entry<&S::interior_point>({.name = "interior-point",
                                 .library = "Ipopt",
                                 .summary = "Newton steps with a barrier that keeps the bounds",
                                 .in_thesis = true,
                                 .needs_gradient = true,
                                 .run = &Call<&S::interior_point, &MinimizeInteriorPoint>}),
      Entry<&S::sqp>({.name = "sqp",
                      .library = "NLopt",
                      .summary = "sequential quadratic programming (SLSQP)",
                      .in_thesis = true,
                      .needs_gradient = true,
                      .run = &Nlopt<&S::sqp, NloptMethod::kSequentialQuadratic>}),
      Entry<&S::active_set>({.name = "active-set",
                             .library = "NLopt",
                             .summary = "quasi-Newton steps with an active set of bounds (L-BFGS)",
                             .in_thesis = true,
                             .needs_gradient = true,
                             .run = &Nlopt<&S::active_set, NloptMethod::kActiveSet>}),
      Entry<&S::levenberg_marquardt>(
          {.name = "levenberg-marquardt",
           .library = "Ceres",
           .summary = "damped Gauss-Newton steps with an active set of bounds; identify's own",
           .in_thesis = true,
           .needs_least_squares = true,
           .needs_gradient = true,
           .run = &LevenbergMarquardt}),
      Entry<&S::genetic>({.name = "genetic",
                          .library = "pagmo",
                          .summary = "parents are mixed and changed at random, the best live on",
                          .in_thesis = true,
                          .needs_box = true,
                          .global = true,
                          .run = &Search<&S::genetic, &MinimizeGenetic>}),
      Entry<&S::particle_swarm>({.name = "particle-swarm",
                                 .library = "pagmo",
                                 .summary = "particles drawn to the best points seen",
                                 .in_thesis = true,
                                 .needs_box = true,
                                 .global = true,
                                 .run = &Search<&S::particle_swarm, &MinimizeParticleSwarm>}),
      Entry<&S::simulated_annealing>(
          {.name = "simulated-annealing",
           .library = "pagmo",
           .summary = "random steps, uphill the less the cooler it is (Corana)",
           .in_thesis = true,
           .needs_box = true,
           .global = true,
           .run = &Search<&S::simulated_annealing, &MinimizeSimulatedAnnealing>}),
      Entry<&S::cma_es>({.name = "cma-es",
                         .library = "pagmo",
                         .summary = "a normal distribution that adapts its covariance",
                         .needs_box = true,
                         .global = true,
                         .run = &Search<&S::cma_es, &MinimizeCmaEs>}),
      Entry<&S::differential_evolution>(
          {.name = "differential-evolution",
           .library = "pagmo",
           .summary = "differences of points as steps",
           .needs_box = true,
           .global = true,
           .run = &Search<&S::differential_evolution, &MinimizeDifferentialEvolution>}),
      Entry<&S::nelder_mead>({.name = "nelder-mead",
                              .library = "NLopt",
                              .summary = "a simplex that moves downhill, without gradients",
                              .run = &Nlopt<&S::nelder_mead, NloptMethod::kNelderMead>}),
      Entry<&S::bobyqa>(
          {.name = "bobyqa",
           .library = "NLopt",
           .summary = "a trust region on an interpolated quadratic, without gradients",
           .run = &Nlopt<&S::bobyqa, NloptMethod::kBobyqa>}),
  };
  return table;
}

OptimizationSummary OptimizerEntry::Minimize(const OptimizationProblem& problem,
                                             const Eigen::VectorXd& start,
                                             const OptimizerSettings& settings) const {
  std::string lacking;
  if (needs_least_squares && dynamic_cast<const LeastSquaresProblem*>(&problem) == nullptr) {
    lacking = "residuals, and the problem has only a cost";
  } else if (needs_gradient && !problem.has_gradient()) {
    lacking = "a gradient, and the problem has none";
  } else if (needs_box && !HasBox(problem)) {
    lacking = "finite bounds of every parameter (--bounds NAME=LOW,HIGH)";
  }
  if (lacking.empty()) return run(problem, start, settings);
  OptimizationSummary refused;
  refused.termination = Termination::kFailure;
  refused.message = fmt::format("{} needs {}.", name, lacking);
  refused.x = start.cwiseMax(problem.lower()).cwiseMin(problem.upper());
  return refused;
}

std::string OptimizerEntry::WhyNoAnswer(const OptimizationSummary& found) const {
  const bool stopped = found.termination == Termination::kMaxIterations;
  if (found.usable() && (!stopped || (global && found.iterations > 0))) return "";
  return fmt::format(
      "{} did not converge ({}){}",
      name,
      found.message,
      stopped ? fmt::format("; allow it more (--set {}.iterations_per_variable=...)", name) : "");
}

const OptimizerEntry& FindOptimizer(std::string_view name) {
  return FindNamed("optimizer", name, Optimizers());
}

}  // namespace lipoid
