#include "identify/optimizers/bobyqa.h"

#include "identify/optimizers/nlopt_adapter.h"

namespace lipoid {

OptimizationSummary MinimizeBobyqa(const OptimizationProblem& problem,
                                   const Eigen::VectorXd& start,
                                   const DirectSearchOptions& options) {
  Monitor monitor(problem, start);
  return MinimizeWithNlopt(monitor,
                           {.method = NloptMethod::kBobyqa,
                            .step_tolerance = options.step_tolerance,
                            .iterations_per_variable = options.iterations_per_variable,
                            .initial_step = options.initial_step});
}

}  // namespace lipoid
