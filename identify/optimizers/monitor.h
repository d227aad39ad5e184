#pragma once

/// @file
/// What stands between a problem and every optimizer's library, so that all treat it alike.
///
/// - Only the free parameters are moved: those with equal bounds are taken out.
/// - Every point is put onto the bounds before the problem sees it.
/// - A cost of NaN, an infinite one and an exception are a failed evaluation, +infinity: nothing is
///   thrown through a library. std::bad_alloc and Stopped are kept, and thrown by Finish().
/// - Evaluations are counted as the problem saw them. A point that is asked again at once, or the
///   best one, is remembered.
/// - The answer is the best point seen, and how the best cost fell is kept.
///
/// Tests: tests/identify/optimizers/monitor_test.cc and conformance_test.cc.

#include <Eigen/Core>
#include <chrono>
#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "identify/optimizers/least_squares.h"
#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

class Monitor {
 public:
  /// Both are kept by reference to the end.
  Monitor(const OptimizationProblem& problem, const Eigen::VectorXd& start);

  [[nodiscard]] int size() const { return static_cast<int>(free_.size()); }  ///< free parameters
  [[nodiscard]] const Eigen::VectorXd& lower() const { return lower_; }
  [[nodiscard]] const Eigen::VectorXd& upper() const { return upper_; }
  [[nodiscard]] const Eigen::VectorXd& start() const { return start_; }
  [[nodiscard]] bool least_squares() const { return least_squares_ != nullptr; }

  /// Evaluates the start. A summary where there is nothing to search: no free parameter, no finite
  /// value at the start (of a local search), or no iteration allowed.
  std::optional<OptimizationSummary> Begin(bool gradient, int max_iterations);

  /// +infinity where the evaluation failed.
  double Cost(const Eigen::VectorXd& x);

  /// The same, and the gradient: NaN where it failed.
  double Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient);

  /// The columns of the free parameters and the residual's; not finite where it failed. Of least
  /// squares only; valid until the next call.
  const Eigen::MatrixXd& Factor(const Eigen::VectorXd& x);

  /// Costs of many points by so many threads (0: all there are). They count in order.
  std::vector<double> Costs(const std::vector<Eigen::VectorXd>& points, int threads);

  /// For libraries that would go on: memory has run out, or somebody asked to stop.
  [[nodiscard]] bool must_stop() const { return fatal_ != nullptr; }

  [[nodiscard]] const Eigen::VectorXd& best() const { return best_.x; }  ///< free parameters
  [[nodiscard]] double best_cost() const { return best_.cost; }

  void CountIterations(int count = 1) { summary_.iterations += count; }
  [[nodiscard]] int iterations() const { return summary_.iterations; }

  /// The summary of all that was seen; a kFailure where nothing finite was.
  OptimizationSummary Finish(Termination termination, std::string message);

 private:
  struct Point {
    Eigen::VectorXd x;
    double cost = std::numeric_limits<double>::infinity();
    Eigen::VectorXd gradient;  // empty: was not asked
    Eigen::MatrixXd factor;

    [[nodiscard]] bool Is(const Eigen::VectorXd& other) const { return x.size() > 0 && x == other; }
  };

  const Point& At(const Eigen::VectorXd& x, bool gradient);
  void Evaluate(Point& point, bool gradient);
  const Point& Keep();
  [[nodiscard]] Eigen::VectorXd Whole(const Eigen::VectorXd& free) const;
  [[nodiscard]] double Seconds() const;

  const OptimizationProblem& problem_;
  const LeastSquaresProblem* least_squares_;
  std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  Eigen::VectorXd whole_start_;
  std::vector<int> free_;
  Eigen::VectorXd lower_, upper_, start_;
  Point best_, last_;
  std::string first_error_;
  std::exception_ptr fatal_;
  OptimizationSummary summary_;
};

}  // namespace lipoid
