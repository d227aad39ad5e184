#pragma once

/// @file
/// NLopt behind a Monitor, for sqp, active-set, nelder-mead and bobyqa. The only place that knows
/// NLopt.
///
/// NLopt does not tell its iterations. With gradients every evaluation of one is counted as an
/// iteration, without them every evaluation; the limit on iterations is ours, the tolerances are
/// the library's. Where the cost has no value NLopt is told a huge one.

#include "identify/optimizers/monitor.h"

namespace lipoid {

enum class NloptMethod { kSequentialQuadratic, kActiveSet, kNelderMead, kBobyqa };

struct NloptSetup {
  NloptMethod method = NloptMethod::kSequentialQuadratic;
  double step_tolerance = 0.0;
  double function_tolerance = 0.0;  ///< of methods with gradients
  int iterations_per_variable = 0;
  double initial_step = 0.0;  ///< relative to |x|, of methods without gradients
};

[[nodiscard]] OptimizationSummary MinimizeWithNlopt(Monitor& monitor, const NloptSetup& setup);

}  // namespace lipoid
