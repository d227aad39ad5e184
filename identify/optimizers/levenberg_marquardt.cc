#include "identify/optimizers/levenberg_marquardt.h"

#include <ceres/ceres.h>

#include <utility>
#include <vector>

#include "identify/optimizers/monitor.h"

namespace lipoid {
namespace {

// The parameters that stand at a bound and would gain nothing by leaving it: the slope points
// outward, or what it promises, g²/(2 J'J), is below the tolerance.
std::vector<bool> HeldAt(const Eigen::VectorXd& x, double function_tolerance, Monitor& monitor) {
  const Eigen::MatrixXd& factor = monitor.Factor(x);
  const Eigen::Index n = x.size();
  const auto residual = factor.col(n);
  std::vector<bool> held(static_cast<std::size_t>(n));
  for (Eigen::Index k = 0; k < n; ++k) {
    const double slope = factor.col(k).dot(residual);
    const bool worthless =
        slope * slope <= function_tolerance * residual.squaredNorm() * factor.col(k).squaredNorm();
    held[static_cast<std::size_t>(k)] =
        (x[k] <= monitor.lower()[k] && (slope >= 0.0 || worthless)) ||
        (x[k] >= monitor.upper()[k] && (slope <= 0.0 || worthless));
  }
  return held;
}

// The problem on its free parameters; Ceres sees n+1 residuals, the rows of the factor.
class FactorCost : public ceres::CostFunction {
 public:
  FactorCost(Monitor& monitor, const Eigen::VectorXd& x, const std::vector<int>& free)
      : monitor_(monitor), x_(x), free_(free) {
    set_num_residuals(static_cast<int>(monitor.Factor(x).rows()));
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }

  [[nodiscard]] Eigen::VectorXd Whole(const double* part) const {
    Eigen::VectorXd x = x_;
    for (std::size_t k = 0; k < free_.size(); ++k) x[free_[k]] = part[k];
    return x;
  }

  bool Evaluate(double const* const* parameters,
                double* residuals,
                double** jacobians) const override {
    const Eigen::MatrixXd& factor = monitor_.Factor(Whole(parameters[0]));
    if (!factor.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, factor.rows()) = factor.rightCols(1);
    if (jacobians != nullptr && jacobians[0] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(
          jacobians[0], factor.rows(), static_cast<Eigen::Index>(free_.size())) =
          factor(Eigen::all, free_);
    }
    return true;
  }

 private:
  Monitor& monitor_;
  Eigen::VectorXd x_;
  const std::vector<int>& free_;
};

// Stops Ceres when a bound takes hold of a parameter: it projects joint steps onto the box, and one
// that wants to go on beyond a bound spoils the steps of the others.
class BoundWatch : public ceres::IterationCallback {
 public:
  BoundWatch(const FactorCost& cost,
             const double* part,
             const std::vector<bool>& held,
             double function_tolerance,
             Monitor& monitor)
      : cost_(cost),
        part_(part),
        held_(held),
        function_tolerance_(function_tolerance),
        monitor_(monitor) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (!iteration.step_is_successful) return ceres::SOLVER_CONTINUE;
    const auto now = HeldAt(cost_.Whole(part_), function_tolerance_, monitor_);
    for (std::size_t k = 0; k < now.size(); ++k) {
      if (now[k] && !held_[k]) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const FactorCost& cost_;
  const double* part_;
  const std::vector<bool>& held_;
  double function_tolerance_;
  Monitor& monitor_;
};

std::vector<int> Free(const std::vector<bool>& held) {
  std::vector<int> free;
  for (std::size_t k = 0; k < held.size(); ++k) {
    if (!held[k]) free.push_back(static_cast<int>(k));
  }
  return free;
}

ceres::Solver::Options SolverOptions(const LevenbergMarquardtOptions& options) {
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.logging_type = ceres::SILENT;
  solver.num_threads = 1;
  solver.function_tolerance = options.function_tolerance;
  solver.parameter_tolerance = options.step_tolerance;
  solver.gradient_tolerance = options.gradient_tolerance;
  solver.update_state_every_iteration = true;
  // Bounded problems would search along every step, ten evaluations where one does.
  solver.max_num_line_search_step_size_iterations = 0;
  return solver;
}

}  // namespace

OptimizationSummary MinimizeLevenbergMarquardt(const LeastSquaresProblem& problem,
                                               const Eigen::VectorXd& start,
                                               const LevenbergMarquardtOptions& options) {
  // Always with the Jacobian: what accepts a step wants it next, and most steps are accepted.
  Monitor monitor(problem, start);
  if (auto done = monitor.Begin(true, options.max_iterations)) return *std::move(done);
  const auto held_at = [&](const Eigen::VectorXd& x) {
    return HeldAt(x, options.function_tolerance, monitor);
  };
  ceres::Solver::Options solver = SolverOptions(options);

  // Rounds of Ceres on the free parameters. A bound takes hold as soon as it is reached, and lets
  // go only when the others have converged.
  Eigen::VectorXd x = monitor.start();
  std::vector<bool> held = held_at(x);
  while (true) {
    std::vector<int> free = Free(held);
    if (free.empty()) {
      // A bound that took hold on the way here may be worth leaving by now.
      held = held_at(x);
      free = Free(held);
    }
    if (free.empty()) {
      return monitor.Finish(Termination::kConverged, "Every parameter stands at a bound.");
    }
    FactorCost cost(monitor, x, free);
    Eigen::VectorXd part = x(free);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem ceres_problem(ownership);
    ceres_problem.AddResidualBlock(&cost, nullptr, part.data());
    for (std::size_t k = 0; k < free.size(); ++k) {
      ceres_problem.SetParameterLowerBound(
          part.data(), static_cast<int>(k), monitor.lower()[free[k]]);
      ceres_problem.SetParameterUpperBound(
          part.data(), static_cast<int>(k), monitor.upper()[free[k]]);
    }
    BoundWatch watch(cost, part.data(), held, options.function_tolerance, monitor);
    solver.callbacks = {&watch};
    solver.max_num_iterations = options.max_iterations - monitor.iterations();
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &ceres_problem, &summary);

    x = cost.Whole(part.data());
    monitor.CountIterations(static_cast<int>(summary.iterations.size()) - 1);  // less the start
    if (!summary.IsSolutionUsable() || monitor.must_stop()) {
      return monitor.Finish(Termination::kFailure, summary.message);
    }

    auto now = held_at(x);
    const bool stopped_at_bound = summary.termination_type == ceres::USER_SUCCESS;
    for (std::size_t k = 0; stopped_at_bound && k < now.size(); ++k) now[k] = now[k] || held[k];
    if (summary.termination_type == ceres::CONVERGENCE && now == held) {
      return monitor.Finish(Termination::kConverged, summary.message);
    }
    if (monitor.iterations() >= options.max_iterations) {
      return monitor.Finish(Termination::kMaxIterations, "The most iterations were made.");
    }
    held = std::move(now);
  }
}

}  // namespace lipoid
