#include "identify/comparison/compare_optimizers.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <random>

#include "identify/comparison/comparison_cautions.h"
#include "model/core/parallel.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// 53 bits of the engine: the same in every standard library.
double Uniform(std::mt19937_64& engine) { return static_cast<double>(engine() >> 11U) * 0x1p-53; }

// A parameter that starts at zero has no decades: its unit stands for it.
double Middle(const PulseVariable& v, const PulseParameters& start) {
  const double p = Entry(start, v);
  return p > 0.0 ? p : v.unit;
}

std::vector<PulseVariable> Boxed(std::vector<PulseVariable> variables,
                                 const PulseParameters& start,
                                 double decades) {
  for (PulseVariable& v : variables) {
    if (!std::isfinite(v.upper)) v.upper = Middle(v, start) * std::pow(10.0, decades);
  }
  return variables;
}

std::vector<PulseParameters> RandomStarts(const std::vector<PulseVariable>& variables,
                                          const PulseParameters& start,
                                          double decades,
                                          int count,
                                          std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::vector<PulseParameters> starts;
  for (int k = 0; k < count; ++k) {
    PulseParameters p = start;
    for (const PulseVariable& v : variables) {
      const double factor = std::pow(10.0, decades * (2.0 * Uniform(engine) - 1.0));
      Entry(p, v) = std::clamp(Middle(v, start) * factor, v.lower, v.upper);
    }
    FollowCapacitances(p);
    starts.push_back(std::move(p));
  }
  return starts;
}

// The first improvement that is good enough; none: the run failed.
const Improvement* Reached(const OptimizationSummary& summary, double cost) {
  const auto found = std::find_if(summary.improvements.begin(),
                                  summary.improvements.end(),
                                  [cost](const Improvement& i) { return i.cost <= cost; });
  return found == summary.improvements.end() ? nullptr : &*found;
}

// Searches stop short of a bound by little. A branch of a thousandth of what the data show is none either.
constexpr double kNoBranch = 1e-3;
bool AtBound(const PulseVariable& variable, double value, double start) {
  constexpr double kNear = 1e-6;
  const double near = kNear * std::max(std::abs(value), std::abs(start));
  const double no_branch = variable.kind == PulseVariable::Kind::kResistance
                               ? kNoBranch * (start - variable.lower)
                               : 0.0;
  return value <= variable.lower + std::max(near, no_branch) || value >= variable.upper - near;
}

}  // namespace

Comparison CompareOptimizers(const VoltageSweep& sweep,
                             const PulseUnknowns& unknowns,
                             const std::vector<const OptimizerEntry*>& optimizers,
                             const OptimizerSettings& settings,
                             int random_starts,
                             const ComparisonOptions& options,
                             const ComparisonProgress& progress) {
  Comparison comparison;
  comparison.variables = unknowns.variables;
  comparison.start = unknowns.start;
  comparison.boxed = Boxed(unknowns.variables, unknowns.start, options.decades);
  const PulseProblem open(sweep, comparison.variables, unknowns.start);
  const PulseProblem boxed(sweep, comparison.boxed, unknowns.start);
  const auto problem = [&](const OptimizerEntry& optimizer) -> const PulseProblem& {
    return optimizer.needs_box ? boxed : open;
  };
  const auto total = optimizers.size() * (1 + static_cast<std::size_t>(random_starts));
  std::atomic<std::size_t> done = 0;
  const auto tell = [&](std::string_view what) {
    if (progress) progress(what, static_cast<double>(done) / static_cast<double>(total));
  };

  // From the data's start one after the other, each with all threads: these are the times shown.
  for (const OptimizerEntry* optimizer : optimizers) {
    tell(optimizer->name);
    OptimizerComparison& result = comparison.results.emplace_back();
    result.optimizer = optimizer->name;
    const PulseProblem& p = problem(*optimizer);
    result.summary = optimizer->Minimize(p, p.Point(unknowns.start), settings);
    result.parameters = p.Parameters(result.summary.x);
    for (const PulseVariable& v : p.variables()) {
      const double found = Entry(result.parameters, v);
      const double start = Entry(unknowns.start, v);
      if (!AtBound(v, found, start)) continue;
      result.at_bound.push_back(v.name);
      if (v.kind == PulseVariable::Kind::kResistance && found <= kNoBranch * start)
        result.gone.push_back(v.branch);
    }
    result.errors = sweep.Errors(result.parameters.sweep);
    ++done;
  }

  // From random starts side by side, each with one thread and a seed of its own.
  const auto starts = RandomStarts(
      comparison.boxed, unknowns.start, options.decades, random_starts, settings.context.seed);
  std::vector<std::vector<OptimizationSummary>> runs(
      optimizers.size(), std::vector<OptimizationSummary>(starts.size()));
  ParallelFor(optimizers.size() * starts.size(), [&](std::size_t task) {
    const std::size_t row = task / starts.size();
    const std::size_t k = task % starts.size();
    const PulseProblem& p = problem(*optimizers[row]);
    OptimizerSettings own = settings;
    own.context.threads = 1;
    own.context.seed = settings.context.seed + 1 + k;
    runs[row][k] = optimizers[row]->Minimize(p, p.Point(starts[k]), own);
    ++done;
    tell(optimizers[row]->name);
  });

  for (std::size_t row = 0; row < runs.size(); ++row) {
    OptimizerComparison& result = comparison.results[row];
    result.best_cost = result.summary.cost;
    for (const auto& run : runs[row]) result.best_cost = std::fmin(result.best_cost, run.cost);
    if (std::isfinite(result.best_cost) && !(result.best_cost >= comparison.best_cost)) {
      comparison.best_cost = result.best_cost;
      comparison.best_optimizer = result.optimizer;
    }
  }
  const double target = comparison.best_cost * (1.0 + options.target);
  const auto rmse_V = [&](double cost) {
    return std::sqrt(2.0 * cost / static_cast<double>(std::max<std::size_t>(1, sweep.rows())));
  };
  const double best_V = rmse_V(comparison.best_cost);
  const auto is_best = [&](double cost) {
    return rmse_V(cost) - best_V <= std::max(kTieFraction * best_V, kTie_V);
  };
  for (const auto& result : comparison.results) {
    if (result.optimizer != comparison.best_optimizer && is_best(result.best_cost))
      comparison.tied.push_back(result.optimizer);
  }
  for (std::size_t row = 0; row < runs.size(); ++row) {
    OptimizerComparison& result = comparison.results[row];
    result.gap = result.summary.cost / comparison.best_cost - 1.0;
    const auto keep = [&](int start, std::uint64_t seed, const OptimizationSummary& run) {
      comparison.runs.push_back({.optimizer = result.optimizer,
                                 .start = start,
                                 .seed = seed,
                                 .summary = run,
                                 .parameters = problem(*optimizers[row]).Parameters(run.x),
                                 .gap = run.cost / comparison.best_cost - 1.0,
                                 .reached = Reached(run, target) != nullptr,
                                 .is_best = is_best(run.cost)});
    };
    keep(0, settings.context.seed, result.summary);
    for (std::size_t k = 0; k < runs[row].size(); ++k)
      keep(static_cast<int>(k) + 1, settings.context.seed + 1 + k, runs[row][k]);
    if (starts.empty()) runs[row].push_back(result.summary);
    for (const auto& run : runs[row]) {
      ++result.starts;
      const Improvement* reached = Reached(run, target);
      if (reached == nullptr) continue;
      ++result.successes;
      result.reached_s.push_back(reached->wall_s);
      result.reached_evaluations.push_back(reached->evaluations);
    }
    std::sort(result.reached_s.begin(), result.reached_s.end());
    std::sort(result.reached_evaluations.begin(), result.reached_evaluations.end());
    result.time_to_target_s = Median(result.reached_s);
    result.evaluations_to_target = Median(result.reached_evaluations);
  }
  const auto best =
      std::find_if(comparison.runs.begin(), comparison.runs.end(), [&](const ComparisonRun& run) {
        return run.optimizer == comparison.best_optimizer &&
               run.summary.cost == comparison.best_cost;
      });
  ErrorMetrics errors;
  if (best != comparison.runs.end()) errors = sweep.Errors(best->parameters.sweep).metrics;
  comparison.best_fit = JudgeErrors(errors.rmse, errors.mean_error_percent);
  if (WhyNoAnswer(comparison).empty()) return comparison;
  // To have come to what is no answer is no success.
  for (ComparisonRun& run : comparison.runs) run.reached = false;
  for (OptimizerComparison& result : comparison.results) {
    result.successes = 0;
    result.time_to_target_s = result.evaluations_to_target =
        std::numeric_limits<double>::quiet_NaN();
    result.reached_s.clear();
    result.reached_evaluations.clear();
  }
  return comparison;
}

}  // namespace lipoid
