#include "identify/optimizers/monitor.h"

#include <tbb/task_arena.h>

#include <atomic>
#include <cmath>
#include <new>
#include <utility>

#include "model/core/parallel.h"
#include "model/core/special_values.h"
#include "model/core/stop.h"

namespace lipoid {

Monitor::Monitor(const OptimizationProblem& problem, const Eigen::VectorXd& start)
    : problem_(problem),
      least_squares_(dynamic_cast<const LeastSquaresProblem*>(&problem)),
      whole_start_(start.cwiseMax(problem.lower()).cwiseMin(problem.upper())) {
  const Eigen::VectorXd lower = problem.lower();
  const Eigen::VectorXd upper = problem.upper();
  for (Eigen::Index k = 0; k < start.size(); ++k) {
    if (lower[k] < upper[k]) free_.push_back(static_cast<int>(k));
  }
  lower_ = lower(free_);
  upper_ = upper(free_);
  start_ = whole_start_(free_);
}

std::optional<OptimizationSummary> Monitor::Begin(bool gradient, int max_iterations) {
  if (!std::isfinite(At(start_, gradient).cost)) return Finish(Termination::kFailure, "");
  if (size() == 0) return Finish(Termination::kConverged, "Every parameter is held by its bounds.");
  if (max_iterations > 0) return std::nullopt;
  return Finish(Termination::kMaxIterations, "No iteration was allowed.");
}

double Monitor::Cost(const Eigen::VectorXd& x) { return At(x, false).cost; }

double Monitor::Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) {
  const Point& point = At(x, true);
  gradient = point.gradient;
  return point.cost;
}

const Eigen::MatrixXd& Monitor::Factor(const Eigen::VectorXd& x) { return At(x, true).factor; }

std::vector<double> Monitor::Costs(const std::vector<Eigen::VectorXd>& points, int threads) {
  std::vector<double> costs(points.size(), kInfinity);
  std::vector<std::string> errors(points.size());
  std::vector<std::exception_ptr> fatal(points.size());
  std::atomic<bool> give_up = must_stop();
  tbb::task_arena arena(threads > 0 ? threads : tbb::task_arena::automatic);
  arena.execute([&] {
    ParallelFor(points.size(), [&](std::size_t k) {
      if (give_up) return;
      try {
        StopIfAsked();
        costs[k] = problem_.Cost(Whole(points[k].cwiseMax(lower_).cwiseMin(upper_)));
      } catch (const std::bad_alloc&) {
        fatal[k] = std::current_exception();
        give_up = true;
      } catch (const Stopped&) {
        fatal[k] = std::current_exception();
        give_up = true;
      } catch (const std::exception& error) {
        errors[k] = error.what();
      } catch (...) {
        errors[k] = "an exception of unknown type";
      }
      if (!std::isfinite(costs[k])) costs[k] = kInfinity;
    });
  });
  for (std::size_t k = 0; k < points.size(); ++k) {
    ++summary_.evaluations;
    if (first_error_.empty()) first_error_ = errors[k];
    if (!fatal_) fatal_ = fatal[k];
    last_ = Point{};
    last_.x = points[k].cwiseMax(lower_).cwiseMin(upper_);
    last_.cost = costs[k];
    Keep();
  }
  return costs;
}

const Monitor::Point& Monitor::At(const Eigen::VectorXd& x, bool gradient) {
  const Eigen::VectorXd inside = x.cwiseMax(lower_).cwiseMin(upper_);
  for (const Point* known : {&best_, &last_}) {
    if (known->Is(inside) && (!gradient || known->gradient.size() > 0)) return *known;
  }
  last_ = Point{};
  last_.x = inside;
  Evaluate(last_, gradient);
  return Keep();
}

// A problem is asked for the gradient only together with the cost.
void Monitor::Evaluate(Point& point, bool gradient) {
  const Eigen::Index n = point.x.size();
  const Eigen::VectorXd whole = Whole(point.x);
  bool finite = false;
  if (!fatal_ && whole.allFinite()) {
    ++summary_.evaluations;
    summary_.gradient_evaluations += gradient ? 1 : 0;
    try {
      StopIfAsked();
      if (!gradient) {
        point.cost = problem_.Cost(whole);
      } else if (least_squares()) {
        const Eigen::MatrixXd factor = least_squares_->Factor(whole, true);
        point.factor.resize(factor.rows(), n + 1);
        point.factor.leftCols(n) = factor(Eigen::all, free_);
        point.factor.rightCols(1) = factor.rightCols(1);
        point.cost = 0.5 * factor.rightCols(1).squaredNorm();
        point.gradient = point.factor.leftCols(n).transpose() * point.factor.rightCols(1);
      } else {
        Eigen::VectorXd all(whole.size());
        point.cost = problem_.Gradient(whole, all);
        point.gradient = all(free_);
      }
      finite = std::isfinite(point.cost) && point.gradient.allFinite();
    } catch (const std::bad_alloc&) {
      fatal_ = std::current_exception();
    } catch (const Stopped&) {
      fatal_ = std::current_exception();
    } catch (const std::exception& error) {
      if (first_error_.empty()) first_error_ = error.what();
    } catch (...) {
      if (first_error_.empty()) first_error_ = "an exception of unknown type";
    }
  }
  if (finite) return;
  point.cost = kInfinity;
  if (!gradient) return;
  point.gradient = Eigen::VectorXd::Constant(n, kNaN);
  if (least_squares()) point.factor = Eigen::MatrixXd::Constant(whole.size() + 1, n + 1, kNaN);
}

// The best point is kept while others are tried: rejected steps lead back to it.
const Monitor::Point& Monitor::Keep() {
  const bool better = last_.cost < best_.cost;
  const bool again = best_.Is(last_.x) && best_.gradient.size() == 0;  // now with its gradient
  if (better) summary_.improvements.push_back({summary_.evaluations, Seconds(), last_.cost});
  if (!better && !(again && last_.cost == best_.cost)) return last_;
  std::swap(best_, last_);
  return best_;
}

Eigen::VectorXd Monitor::Whole(const Eigen::VectorXd& free) const {
  Eigen::VectorXd whole = whole_start_;
  whole(free_) = free;
  return whole;
}

double Monitor::Seconds() const {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
}

OptimizationSummary Monitor::Finish(Termination termination, std::string message) {
  if (fatal_) std::rethrow_exception(fatal_);
  const bool found =
      best_.x.size() == static_cast<Eigen::Index>(free_.size()) && std::isfinite(best_.cost);
  summary_.termination = found ? termination : Termination::kFailure;
  summary_.message = std::move(message);
  if (!found) {
    summary_.message = summary_.evaluations == 1 ? "There is no finite value where it started."
                                                 : "No point with a finite value was found.";
  }
  if (!first_error_.empty() && (!found || termination == Termination::kFailure)) {
    summary_.message += " The first error was: " + first_error_;
  }
  summary_.x = found ? Whole(best_.x) : whole_start_;
  summary_.cost = found ? best_.cost : kNaN;
  summary_.wall_s = Seconds();
  return summary_;
}

}  // namespace lipoid
