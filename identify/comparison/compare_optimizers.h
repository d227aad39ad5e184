#pragma once

/// @file
/// Optimizers on the same problem: (4.60) or (4.61) over the same logs, in the thesis' own unknowns
/// beta, r_s, r_j, c_j, from the same start, judged by the same errors (Tables 4.4-4.6).
///
/// Optimizers that search a box get one, since resistances and capacitances have no upper bound of
/// their own: `decades` above the start, or what the user says. Random starts are log-uniform over
/// so many decades on either side of the start, the same for all. A run succeeds when its cost is
/// within `target` of the best that any run found. Same seed, same results for any number of
/// threads, times aside. Tests: tests/identify/comparison/compare_optimizers_test.cc.

#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "identify/fit_quality.h"
#include "identify/optimizers/optimizers.h"
#include "identify/stages/pulse_problem.h"
#include "identify/stages/voltage_sweep.h"
#include "model/core/options.h"

namespace lipoid {

struct ComparisonOptions {
  ParameterScale scaling = ParameterScale::kTypical;
  double decades = 2.0;
  double target = 1e-3;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("scaling",
      self.scaling,
      Names{},
      "scale of what the optimizers move: SI values, SI values over typical ones, or their "
      "logarithms");
    v("decades",
      self.decades,
      Range{0.0, 6.0},
      "decades of random starts on either side of the data's start, and of the box above it");
    v("target",
      self.target,
      Range{0.0, 10.0},
      "relative distance to the best cost within which a start has succeeded");
  }
};

/// One optimizer. Times belong to this machine, all else to the seed.
struct OptimizerComparison {
  std::string optimizer;
  OptimizationSummary summary;  ///< from the data's start
  PulseParameters parameters;
  std::vector<std::string> at_bound;  ///< parameters that ended at a bound of the problem
  std::vector<std::size_t> gone;      ///< branches, from 0, whose resistance ended as none
  SweepErrors errors;                 ///< over all rows
  double gap = std::numeric_limits<double>::quiet_NaN();        ///< cost / best cost - 1
  int starts = 0;                                               ///< random ones, or 1: the data's
  int successes = 0;                                            ///< of those
  double best_cost = std::numeric_limits<double>::quiet_NaN();  ///< of all its runs
  /// Medians over the runs that succeeded; NaN where none did.
  double time_to_target_s = std::numeric_limits<double>::quiet_NaN();
  double evaluations_to_target = std::numeric_limits<double>::quiet_NaN();
  /// Of the runs that succeeded, each sorted: how many got there within so much.
  std::vector<double> reached_s;
  std::vector<double> reached_evaluations;

  [[nodiscard]] double success_rate() const { return static_cast<double>(successes) / starts; }
};

/// One run of one optimizer.
struct ComparisonRun {
  std::string optimizer;
  int start = 0;           ///< 0: the data's, else the number of the random start
  std::uint64_t seed = 0;  ///< of optimizers that draw
  OptimizationSummary summary;
  PulseParameters parameters;
  double gap = std::numeric_limits<double>::quiet_NaN();  ///< cost / best cost - 1
  bool reached = false;                                   ///< the target
  bool is_best = false;                                   ///< or as good, but for rounding
};

struct Comparison {
  std::vector<PulseVariable> variables;
  std::vector<PulseVariable> boxed;  ///< the same with the box of those that need one
  PulseParameters start;
  double best_cost = std::numeric_limits<double>::quiet_NaN();
  std::string best_optimizer;
  /// Of the best, over all rows: gaps and successes are against it, and say nothing where it is poor.
  FitQuality best_fit;
  /// The others whose best fit is the same but for rounding: their root mean square errors agree
  /// within kTieFraction of them, or within kTie_V. The best is then one of several.
  std::vector<std::string> tied;
  std::vector<OptimizerComparison> results;  ///< in the order asked for
  std::vector<ComparisonRun> runs;           ///< by optimizer, then by start, the data's first
};

/// Solvers end within 1e-8 of their unknowns, which moves the cost by the square; a voltmeter does
/// not see a nanovolt.
inline constexpr double kTieFraction = 1e-6;
inline constexpr double kTie_V = 1e-9;

/// Called with the name of what runs and the share of the work done.
using ComparisonProgress = std::function<void(std::string_view what, double share)>;

/// `unknowns` say what is free, in which scale, and where it starts. With random_starts = 0 each
/// optimizer runs once, from there; otherwise so many times more.
[[nodiscard]] Comparison CompareOptimizers(const VoltageSweep& sweep,
                                           const PulseUnknowns& unknowns,
                                           const std::vector<const OptimizerEntry*>& optimizers,
                                           const OptimizerSettings& settings,
                                           int random_starts,
                                           const ComparisonOptions& options = {},
                                           const ComparisonProgress& progress = {});

}  // namespace lipoid
