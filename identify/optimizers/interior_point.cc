#include "identify/optimizers/interior_point.h"

#include <tbb/task_arena.h>

#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>
#include <cmath>
#include <mutex>

#include "identify/optimizers/monitor.h"

namespace lipoid {
namespace {

using Ipopt::Index;
using Ipopt::Number;

// Ipopt's view of the problem. Value and gradient are asked together: most steps are accepted.
class BarrierProblem : public Ipopt::TNLP {
 public:
  BarrierProblem(Monitor& monitor, const InteriorPointOptions& options)
      : monitor_(monitor),
        options_(options),
        newton_(monitor.least_squares() && options.hessian == HessianSource::kGaussNewton),
        unit_(monitor.best_cost() != 0.0 ? std::abs(monitor.best_cost()) : 1.0) {}

  [[nodiscard]] bool newton() const { return newton_; }
  [[nodiscard]] bool small_steps() const { return small_steps_; }
  [[nodiscard]] bool small_change() const { return small_change_; }

  bool get_nlp_info(Index& n,
                    Index& constraints,
                    Index& jacobian_entries,
                    Index& hessian_entries,
                    IndexStyleEnum& style) override {
    n = monitor_.size();
    constraints = 0;
    jacobian_entries = 0;
    hessian_entries = n * (n + 1) / 2;
    style = C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index, Number*, Number*) override {
    Eigen::Map<Eigen::VectorXd>(lower, n) = monitor_.lower();
    Eigen::Map<Eigen::VectorXd>(upper, n) = monitor_.upper();
    return true;
  }

  bool get_starting_point(
      Index n, bool, Number* x, bool, Number*, Number*, Index, bool, Number*) override {
    Eigen::Map<Eigen::VectorXd>(x, n) = monitor_.start();
    return true;
  }

  bool eval_f(Index n, const Number* x, bool, Number& cost) override {
    Eigen::VectorXd gradient;
    cost = monitor_.Gradient(Eigen::Map<const Eigen::VectorXd>(x, n), gradient) / unit_;
    return std::isfinite(cost);
  }

  bool eval_grad_f(Index n, const Number* x, bool, Number* gradient) override {
    Eigen::VectorXd slope;
    const double cost = monitor_.Gradient(Eigen::Map<const Eigen::VectorXd>(x, n), slope);
    Eigen::Map<Eigen::VectorXd>(gradient, n) = slope / unit_;
    return std::isfinite(cost);
  }

  bool eval_g(Index, const Number*, bool, Index, Number*) override { return true; }
  bool eval_jac_g(Index, const Number*, bool, Index, Index, Index*, Index*, Number*) override {
    return true;
  }

  // The lower triangle of J'J.
  bool eval_h(Index n,
              const Number* x,
              bool,
              Number factor,
              Index,
              const Number*,
              bool,
              Index,
              Index* rows,
              Index* columns,
              Number* values) override {
    Eigen::MatrixXd hessian;
    if (values != nullptr) {
      const auto& r = monitor_.Factor(Eigen::Map<const Eigen::VectorXd>(x, n));
      hessian = factor / unit_ * r.leftCols(n).transpose() * r.leftCols(n);
      if (!hessian.allFinite()) return false;
    }
    Index entry = 0;
    for (Index row = 0; row < n; ++row) {
      for (Index column = 0; column <= row; ++column, ++entry) {
        if (values != nullptr) {
          values[entry] = hessian(row, column);
        } else {
          rows[entry] = row;
          columns[entry] = column;
        }
      }
    }
    return true;
  }

  // Our stops. A step is small only if the one before was: the first step of each barrier may be.
  bool intermediate_callback(Ipopt::AlgorithmMode,
                             Index iteration,
                             Number cost,
                             Number,
                             Number,
                             Number,
                             Number step,
                             Number,
                             Number,
                             Number share,
                             Index,
                             const Ipopt::IpoptData*,
                             Ipopt::IpoptCalculatedQuantities*) override {
    if (monitor_.must_stop()) return false;
    if (iteration == 0) {
      last_cost_ = cost;
      return true;
    }
    monitor_.CountIterations();
    const double x = monitor_.best().lpNorm<Eigen::Infinity>();
    const bool small_step = share * step <= options_.step_tolerance * x;
    const bool small_change =
        std::abs(cost - last_cost_) <= options_.function_tolerance * std::abs(cost);
    small_steps_ = small_step && last_small_step_;
    small_change_ = small_change && last_small_change_;
    last_small_step_ = small_step;
    last_small_change_ = small_change;
    last_cost_ = cost;
    return !small_steps_ && !small_change_;
  }

  void finalize_solution(Ipopt::SolverReturn,
                         Index,
                         const Number*,
                         const Number*,
                         const Number*,
                         Index,
                         const Number*,
                         const Number*,
                         Number,
                         const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {}

 private:
  Monitor& monitor_;
  const InteriorPointOptions& options_;
  bool newton_;
  double unit_;  // Ipopt sees costs relative to that of the start: its tolerances are absolute
  double last_cost_ = 0.0;
  bool last_small_step_ = false, last_small_change_ = false;
  bool small_steps_ = false, small_change_ = false;
};

Ipopt::ApplicationReturnStatus Solve(BarrierProblem* problem, int most) {
  Ipopt::IpoptApplication ipopt(false);  // no console
  const auto options = ipopt.Options();
  options->SetIntegerValue("print_level", 0);
  options->SetStringValue("sb", "yes");
  options->SetStringValue("option_file_name", "");
  options->SetIntegerValue("max_iter", most);
  options->SetNumericValue("tol", 1e-11);
  options->SetNumericValue("bound_relax_factor", 0.0);
  options->SetNumericValue("nlp_lower_bound_inf", -1e300);
  options->SetNumericValue("nlp_upper_bound_inf", 1e300);
  options->SetStringValue("hessian_approximation", problem->newton() ? "exact" : "limited-memory");
  const auto status = ipopt.Initialize();
  if (status != Ipopt::Solve_Succeeded) return status;
  return ipopt.OptimizeTNLP(problem);
}

OptimizationSummary Minimize(const OptimizationProblem& problem,
                             const Eigen::VectorXd& start,
                             const InteriorPointOptions& options) {
  Monitor monitor(problem, start);
  const int most = options.iterations_per_variable * monitor.size();
  if (auto done = monitor.Begin(true, most)) return *std::move(done);

  const Ipopt::SmartPtr<BarrierProblem> barrier = new BarrierProblem(monitor, options);
  switch (Solve(Ipopt::GetRawPtr(barrier), most)) {
    case Ipopt::Solve_Succeeded:
    case Ipopt::Solved_To_Acceptable_Level:
      return monitor.Finish(Termination::kConverged, "The optimality conditions hold.");
    case Ipopt::Search_Direction_Becomes_Too_Small:
      return monitor.Finish(Termination::kConverged, "Rounding errors allow no further step.");
    case Ipopt::User_Requested_Stop:
      return monitor.Finish(Termination::kConverged,
                            barrier->small_steps()
                                ? "The steps became small (step_tolerance)."
                                : "The cost changed little (function_tolerance).");
    case Ipopt::Maximum_Iterations_Exceeded:
      return monitor.Finish(Termination::kMaxIterations, "The most iterations were made.");
    default:
      return monitor.Finish(Termination::kFailure, "Ipopt found no step that helps.");
  }
}

}  // namespace

// One solve at a time, and the clock runs only for it. A thread that waits inside for work of its
// own may not take up another solve: that would wait for itself.
OptimizationSummary MinimizeInteriorPoint(const OptimizationProblem& problem,
                                          const Eigen::VectorXd& start,
                                          const InteriorPointOptions& options) {
  return tbb::this_task_arena::isolate([&] {
    static std::mutex one_at_a_time;
    const std::lock_guard lock(one_at_a_time);
    return Minimize(problem, start, options);
  });
}

}  // namespace lipoid
