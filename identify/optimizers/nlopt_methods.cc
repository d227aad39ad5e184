#include "identify/optimizers/nlopt_methods.h"

#include <nlopt.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <new>
#include <vector>

#include "identify/optimizers/monitor.h"

namespace lipoid {
namespace {

struct DestroyNlopt {
  void operator()(nlopt_opt library) const { nlopt_destroy(library); }
};
using NloptHandle = std::unique_ptr<nlopt_opt_s, DestroyNlopt>;

struct Method {
  nlopt_algorithm algorithm;
  bool uses_gradient;
  bool smooth;  // models the cost by a polynomial, which cannot pass through infinity
};

constexpr Method MethodOf(NloptMethod method) {
  switch (method) {
    case NloptMethod::kSequentialQuadratic:
      return {NLOPT_LD_SLSQP, true, false};
    case NloptMethod::kActiveSet:
      return {NLOPT_LD_LBFGS, true, false};
    case NloptMethod::kNelderMead:
      return {NLOPT_LN_NELDERMEAD, false, false};
    case NloptMethod::kBobyqa:
      break;
  }
  return {NLOPT_LN_BOBYQA, false, true};
}

struct Evaluation {
  Monitor& monitor;
  nlopt_opt library;
  const Method& method;
  int max_iterations;
  double unit;     // NLopt sees costs relative to that of the start: some tolerances are absolute
  double highest;  // cost seen
};

// Called from C: nothing is thrown.
double CostOf(unsigned n, const double* x, double* gradient, void* data) {
  Evaluation& call = *static_cast<Evaluation*>(data);
  const auto size = static_cast<Eigen::Index>(n);
  const Eigen::VectorXd point = Eigen::Map<const Eigen::VectorXd>(x, size);
  double cost = 0.0;
  if (gradient == nullptr) {
    cost = call.monitor.Cost(point);
  } else {
    Eigen::VectorXd slope;
    cost = call.monitor.Gradient(point, slope);
    if (!std::isfinite(cost)) slope.setZero();
    Eigen::Map<Eigen::VectorXd>(gradient, size) = slope / call.unit;
  }
  if (gradient != nullptr || !call.method.uses_gradient) call.monitor.CountIterations();
  if (call.monitor.must_stop() || call.monitor.iterations() >= call.max_iterations) {
    nlopt_force_stop(call.library);
  }
  // A quadratic model cannot pass through infinity: there the wall is as high as the hills.
  if (!std::isfinite(cost)) return call.method.smooth ? call.highest / call.unit : HUGE_VAL;
  call.highest = std::max(call.highest, cost);
  return cost / call.unit;
}

// NLopt knows no bound by its infinity.
std::vector<double> BoundsOf(const Eigen::VectorXd& bounds) {
  std::vector<double> all;
  for (const double bound : bounds) {
    all.push_back(IsBound(bound) ? bound : std::copysign(HUGE_VAL, bound));
  }
  return all;
}

// A tenth of each parameter, say, as far as a quarter of the room between its bounds.
std::vector<double> InitialSteps(const Monitor& monitor, double relative) {
  std::vector<double> steps;
  for (Eigen::Index k = 0; k < monitor.size(); ++k) {
    const double x = std::abs(monitor.start()[k]);
    const double wanted = relative * (x > 0.0 ? x : 1.0);
    const bool bounded = IsBound(monitor.lower()[k]) && IsBound(monitor.upper()[k]);
    const double room = bounded ? monitor.upper()[k] - monitor.lower()[k] : kUnbounded;
    steps.push_back(std::min(wanted, 0.25 * room));
  }
  return steps;
}

// The first step of a quasi-Newton method is its gradient: in this unit no longer than x.
double Unit(Monitor& monitor, bool uses_gradient) {
  double unit = std::abs(monitor.best_cost());
  if (uses_gradient) {
    Eigen::VectorXd gradient;
    monitor.Gradient(monitor.start(), gradient);
    const double length = monitor.start().norm();
    unit = std::max(unit, gradient.norm() / (length > 0.0 ? length : 1.0));
  }
  return unit > 0.0 ? unit : 1.0;
}

// Whether a step down the gradient, within the bounds, lowers the cost by more than what is left where a search of
// finite tolerances ends. Where the slope alone says that it does not, nothing is evaluated.
bool StillFalls(Monitor& monitor, double first_cost) {
  constexpr double kSuspicious = 0.1;  // of the cost, by the slope over the size of x
  constexpr double kClearly = 1e-3;    // of the cost
  constexpr double kWorthIt = 1e-9;    // of that at the start: nobody gains from less
  const Eigen::VectorXd x = monitor.best();
  const double cost = monitor.best_cost();
  const double size = x.norm() > 0.0 ? x.norm() : 1.0;
  const double worth = kWorthIt * first_cost;
  Eigen::VectorXd down;
  if (!std::isfinite(monitor.Gradient(x, down)) || !down.allFinite()) return false;
  down *= -1.0;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    const bool out = (x[k] <= monitor.lower()[k] && down[k] < 0.0) ||
                     (x[k] >= monitor.upper()[k] && down[k] > 0.0);
    if (out) down[k] = 0.0;
  }
  const double slope = down.norm();
  if (!(slope * size > std::max(kSuspicious * cost, worth))) return false;
  const double less = std::max(kClearly * cost, worth);
  for (double step = 0.1 * size; step > 1e-5 * size; step *= 0.25) {
    const Eigen::VectorXd to =
        (x + step / slope * down).cwiseMax(monitor.lower()).cwiseMin(monitor.upper());
    if (monitor.Cost(to) < cost - less) return true;
  }
  return false;
}

OptimizationSummary Ended(Monitor& monitor,
                          double first_cost,
                          nlopt_result result,
                          const char* why,
                          bool limit,
                          bool uses_gradient) {
  if (uses_gradient && result > 0 && !limit && StillFalls(monitor, first_cost)) {
    return monitor.Finish(
        Termination::kStalled,
        "It stopped short: the cost still falls from here by a thousandth or more, down its gradient.");
  }
  switch (result) {
    case NLOPT_XTOL_REACHED:
      return monitor.Finish(Termination::kConverged, "The steps became small (step_tolerance).");
    case NLOPT_FTOL_REACHED:
      return monitor.Finish(Termination::kConverged,
                            "The cost changed little (function_tolerance).");
    case NLOPT_SUCCESS:
      return monitor.Finish(
          Termination::kConverged,
          uses_gradient ? "The gradient vanished." : "The search region became small.");
    case NLOPT_ROUNDOFF_LIMITED:
      return monitor.Finish(Termination::kConverged, "Rounding errors allow no further step.");
    case NLOPT_FORCED_STOP:
      if (limit) {
        return monitor.Finish(Termination::kMaxIterations, "The most iterations were made.");
      }
      break;
    default:
      break;
  }
  return monitor.Finish(Termination::kFailure,
                        why != nullptr ? why : "NLopt found no step that helps.");
}

// The initial step is relative to |x|; 0: the library's.
OptimizationSummary Minimize(const Method& method,
                             const OptimizationProblem& problem,
                             const Eigen::VectorXd& start,
                             const LocalSearchOptions& stop,
                             double initial_step) {
  Monitor monitor(problem, start);
  const int most = stop.iterations_per_variable * monitor.size();
  if (auto done = monitor.Begin(method.uses_gradient, most)) return *std::move(done);

  const double first_cost = monitor.best_cost();
  const NloptHandle library(nlopt_create(method.algorithm, static_cast<unsigned>(monitor.size())));
  if (library == nullptr) throw std::bad_alloc();
  Evaluation call{.monitor = monitor,
                  .library = library.get(),
                  .method = method,
                  .max_iterations = most,
                  .unit = Unit(monitor, method.uses_gradient),
                  .highest = monitor.best_cost()};
  nlopt_set_min_objective(library.get(), &CostOf, &call);
  nlopt_set_lower_bounds(library.get(), BoundsOf(monitor.lower()).data());
  nlopt_set_upper_bounds(library.get(), BoundsOf(monitor.upper()).data());
  nlopt_set_xtol_rel(library.get(), stop.step_tolerance);
  nlopt_set_ftol_rel(library.get(), stop.function_tolerance);
  if (initial_step > 0.0) {
    nlopt_set_initial_step(library.get(), InitialSteps(monitor, initial_step).data());
  }
  std::vector<double> x(monitor.start().begin(), monitor.start().end());
  double cost = 0.0;
  const nlopt_result result = nlopt_optimize(library.get(), x.data(), &cost);
  return Ended(monitor,
               first_cost,
               result,
               nlopt_get_errmsg(library.get()),
               monitor.iterations() >= most,
               method.uses_gradient);
}

}  // namespace

OptimizationSummary MinimizeWithNlopt(NloptMethod method,
                                      const OptimizationProblem& problem,
                                      const Eigen::VectorXd& start,
                                      const LocalSearchOptions& options) {
  return Minimize(MethodOf(method), problem, start, options, 0.0);
}

OptimizationSummary MinimizeWithNlopt(NloptMethod method,
                                      const OptimizationProblem& problem,
                                      const Eigen::VectorXd& start,
                                      const DirectSearchOptions& options) {
  return Minimize(MethodOf(method),
                  problem,
                  start,
                  {.step_tolerance = options.step_tolerance,
                   .function_tolerance = 0.0,
                   .iterations_per_variable = options.iterations_per_variable},
                  options.initial_step);
}

}  // namespace lipoid
