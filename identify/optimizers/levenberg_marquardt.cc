#include "identify/optimizers/levenberg_marquardt.h"

#include <ceres/ceres.h>

#include <chrono>

namespace lipoid {
namespace {

// The problem with some parameters held where they are; Ceres sees n+1 residuals, the rows of the factor.
class FactorCost : public ceres::CostFunction {
 public:
  FactorCost(const LeastSquaresProblem& problem, const Eigen::VectorXd& x, const std::vector<int>& free,
             LeastSquaresSummary& summary)
      : problem_(problem), x_(x), free_(free), summary_(summary) {
    set_num_residuals(problem.size() + 1);
    mutable_parameter_block_sizes()->push_back(static_cast<int>(free.size()));
  }

  [[nodiscard]] Eigen::VectorXd Whole(const double* part) const {
    Eigen::VectorXd x = x_;
    for (std::size_t k = 0; k < free_.size(); ++k) x[free_[k]] = part[k];
    return x;
  }

  bool Evaluate(double const* const* parameters, double* residuals, double** jacobians) const override {
    const int n = problem_.size();
    const bool jacobian = jacobians != nullptr && jacobians[0] != nullptr;
    ++summary_.evaluations;
    if (jacobian) ++summary_.gradient_evaluations;
    const Eigen::MatrixXd factor = problem_.Factor(Whole(parameters[0]), jacobian);
    if (!factor.allFinite()) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, n + 1) = factor.col(n);
    if (jacobian) {
      Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>> rows(
          jacobians[0], n + 1, static_cast<Eigen::Index>(free_.size()));
      for (std::size_t k = 0; k < free_.size(); ++k) rows.col(static_cast<Eigen::Index>(k)) = factor.col(free_[k]);
    }
    return true;
  }

 private:
  const LeastSquaresProblem& problem_;
  const Eigen::VectorXd& x_;
  const std::vector<int>& free_;
  LeastSquaresSummary& summary_;
};

// Stops Ceres when a parameter has stood at a bound for two accepted steps: it projects joint steps onto
// the box and then creeps along it.
class BoundWatch : public ceres::IterationCallback {
 public:
  BoundWatch(const Eigen::VectorXd& x, Eigen::VectorXd lower, Eigen::VectorXd upper)
      : x_(x), lower_(std::move(lower)), upper_(std::move(upper)), stood_(Eigen::VectorXi::Zero(x.size())) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& iteration) override {
    if (!iteration.step_is_successful) return ceres::SOLVER_CONTINUE;
    for (Eigen::Index k = 0; k < x_.size(); ++k) {
      stood_[k] = x_[k] == lower_[k] || x_[k] == upper_[k] ? stood_[k] + 1 : 0;
      if (stood_[k] > 2) return ceres::SOLVER_TERMINATE_SUCCESSFULLY;
    }
    return ceres::SOLVER_CONTINUE;
  }

 private:
  const Eigen::VectorXd& x_;
  Eigen::VectorXd lower_, upper_;
  Eigen::VectorXi stood_;
};

// Parameters that stand at a bound and would only get worse by leaving it.
std::vector<bool> HeldAtBounds(const LeastSquaresProblem& problem, const Eigen::VectorXd& x) {
  const int n = problem.size();
  const Eigen::MatrixXd factor = problem.Factor(x, true);
  const Eigen::VectorXd gradient = factor.leftCols(n).transpose() * factor.col(n);
  const Eigen::VectorXd lower = problem.lower();
  const Eigen::VectorXd upper = problem.upper();
  std::vector<bool> held(static_cast<std::size_t>(n));
  for (int k = 0; k < n; ++k) {
    held[static_cast<std::size_t>(k)] =
        (x[k] <= lower[k] && gradient[k] >= 0.0) || (x[k] >= upper[k] && gradient[k] <= 0.0);
  }
  return held;
}

}  // namespace

LeastSquaresSummary MinimizeLevenbergMarquardt(const LeastSquaresProblem& problem,
                                               const Eigen::VectorXd& start,
                                               const LevenbergMarquardtOptions& options) {
  const auto began = std::chrono::steady_clock::now();
  LeastSquaresSummary result;
  const Eigen::VectorXd lower = problem.lower();
  const Eigen::VectorXd upper = problem.upper();
  result.x = start.cwiseMax(lower).cwiseMin(upper);

  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.logging_type = ceres::SILENT;
  solver.num_threads = 1;
  solver.function_tolerance = options.function_tolerance;
  solver.parameter_tolerance = options.step_tolerance;
  solver.gradient_tolerance = options.gradient_tolerance;
  solver.max_num_iterations = options.max_iterations;
  solver.update_state_every_iteration = true;

  // Rounds of Ceres on the free parameters; between them bounds take hold of parameters and let go of them.
  constexpr int kMostRounds = 20;
  std::vector<bool> held(static_cast<std::size_t>(problem.size()), false);
  for (int round = 0; round < kMostRounds; ++round) {
    std::vector<int> free;
    for (int k = 0; k < problem.size(); ++k) {
      if (!held[static_cast<std::size_t>(k)]) free.push_back(k);
    }
    if (free.empty()) {
      result.termination = Termination::kConverged;
      result.message = "Every parameter stands at a bound.";
      result.cost = 0.5 * problem.Factor(result.x, false).rightCols(1).squaredNorm();
      break;
    }
    const Eigen::VectorXd from = result.x;
    FactorCost cost(problem, from, free, result);
    Eigen::VectorXd part = from(free);
    ceres::Problem::Options ownership;
    ownership.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
    ceres::Problem ceres_problem(ownership);
    ceres_problem.AddResidualBlock(&cost, nullptr, part.data());
    for (std::size_t k = 0; k < free.size(); ++k) {
      ceres_problem.SetParameterLowerBound(part.data(), static_cast<int>(k), lower[free[k]]);
      ceres_problem.SetParameterUpperBound(part.data(), static_cast<int>(k), upper[free[k]]);
    }
    BoundWatch watch(part, lower(free), upper(free));
    solver.callbacks = {&watch};
    ceres::Solver::Summary summary;
    ceres::Solve(solver, &ceres_problem, &summary);

    result.x = cost.Whole(part.data());
    result.cost = summary.final_cost;
    result.iterations += static_cast<int>(summary.iterations.size());
    result.message = summary.message;
    switch (summary.termination_type) {
      case ceres::CONVERGENCE:
      case ceres::USER_SUCCESS: result.termination = Termination::kConverged; break;
      case ceres::NO_CONVERGENCE: result.termination = Termination::kMaxIterations; break;
      default: result.termination = Termination::kFailure; break;
    }
    if (result.termination != Termination::kConverged) break;
    ++result.evaluations;
    ++result.gradient_evaluations;
    const auto now_held = HeldAtBounds(problem, result.x);
    if (now_held == held) {
      if (summary.termination_type == ceres::CONVERGENCE) break;
      // The watch stopped it, yet the bound need not hold: once more, to the tolerances.
      solver.callbacks.clear();
    }
    held = now_held;
    result.termination = Termination::kMaxIterations;
    result.message = "Parameters kept changing between bound and free.";
  }
  result.wall_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  return result;
}

}  // namespace lipoid
