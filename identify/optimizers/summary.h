#pragma once

/// @file
/// What an optimizer did: where it ended, why, and what it cost. The answer is always the best
/// point that was seen.

#include <Eigen/Core>
#include <array>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lipoid {

enum class Termination {
  kNotRun,
  kConverged,  ///< a tolerance was met
  kMaxIterations,
  kStalled,  ///< many iterations brought no improvement: how global searches end
  kFailure,  ///< no finite value where it started, or no step that helps
};

constexpr std::array<std::pair<Termination, std::string_view>, 5> OptionNames(Termination) {
  return {{{Termination::kNotRun, "not-run"},
           {Termination::kConverged, "converged"},
           {Termination::kMaxIterations, "max-iterations"},
           {Termination::kStalled, "stalled"},
           {Termination::kFailure, "failure"}}};
}

/// The best cost after so many evaluations.
struct Improvement {
  int evaluations = 0;
  double wall_s = 0.0;
  double cost = std::numeric_limits<double>::quiet_NaN();
};

struct OptimizationSummary {
  Termination termination = Termination::kNotRun;
  std::string message = "Minimize() was not called.";
  Eigen::VectorXd x;
  double cost = std::numeric_limits<double>::quiet_NaN();  ///< at x; of least squares 1/2 ||r||²
  int iterations = 0;
  int evaluations = 0;           ///< of the cost, with or without its gradient
  int gradient_evaluations = 0;  ///< of those, with
  double wall_s = 0.0;
  std::vector<Improvement> improvements;  ///< of the best cost, each better than the one before

  [[nodiscard]] bool usable() const {
    return termination != Termination::kNotRun && termination != Termination::kFailure;
  }
};

}  // namespace lipoid
