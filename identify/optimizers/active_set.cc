#include "identify/optimizers/active_set.h"

#include "identify/optimizers/nlopt_adapter.h"

namespace lipoid {

OptimizationSummary MinimizeActiveSet(const OptimizationProblem& problem,
                                      const Eigen::VectorXd& start,
                                      const LocalSearchOptions& options) {
  Monitor monitor(problem, start);
  return MinimizeWithNlopt(monitor,
                           {.method = NloptMethod::kActiveSet,
                            .step_tolerance = options.step_tolerance,
                            .function_tolerance = options.function_tolerance,
                            .iterations_per_variable = options.iterations_per_variable});
}

}  // namespace lipoid
