#pragma once

/// @file
/// Bounded nonlinear least squares as every optimizer here sees it: minimize 1/2 ||r(x)||² with lo
/// <= x <= hi.
///
/// A log has millions of rows and a cell four parameters, so a problem does not hand out r and its
/// Jacobian J but the triangular factor R of [J r]: n+1 rows whose norms, gradients and
/// Gauss-Newton matrix are those of all rows (docs/theory.md, "One sweep"). Being a QR factor it
/// keeps the digits that J'J would square away. Parameters are what the optimizer moves: scaled, of
/// order one; see PulseProblem for the physical ones. Tests:
/// tests/identify/optimizers/levenberg_marquardt_test.cc.

#include <Eigen/Core>
#include <array>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lipoid {

class LeastSquaresProblem {
 public:
  virtual ~LeastSquaresProblem() = default;

  [[nodiscard]] virtual int size() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd lower() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd upper() const = 0;

  /// The (n+1) x (n+1) upper triangular factor of [J r] at x; its last column alone where the
  /// Jacobian is not wanted: the norm of r stands at the bottom right. Not finite where the model
  /// has no value.
  [[nodiscard]] virtual Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const = 0;
};

enum class Termination {
  kNotRun,
  kConverged,  ///< a tolerance was met
  kMaxIterations,
  kFailure,  ///< no finite value where it started, or no step that helps
};

constexpr std::array<std::pair<Termination, std::string_view>, 4> OptionNames(Termination) {
  return {{{Termination::kNotRun, "not-run"},
           {Termination::kConverged, "converged"},
           {Termination::kMaxIterations, "max-iterations"},
           {Termination::kFailure, "failure"}}};
}

struct LeastSquaresSummary {
  Termination termination = Termination::kNotRun;
  std::string message = "Minimize() was not called.";
  Eigen::VectorXd x;
  double cost = std::numeric_limits<double>::quiet_NaN();  ///< 1/2 ||r||² at x
  int iterations = 0;
  int evaluations = 0;           ///< of r, with or without its Jacobian
  int gradient_evaluations = 0;  ///< of those, with
  double wall_s = 0.0;

  [[nodiscard]] bool usable() const {
    return termination == Termination::kConverged || termination == Termination::kMaxIterations;
  }
};

}  // namespace lipoid
