#pragma once

/// @file
/// Bounded nonlinear least squares as every optimizer here sees it: minimize 1/2 ||r(x)||² with lo
/// <= x <= hi.
///
/// A log has millions of rows and a cell four parameters, so a problem does not hand out r and its
/// Jacobian J but the triangular factor R of [J r]: n+1 rows whose norms, gradients and
/// Gauss-Newton matrix are those of all rows (docs/theory.md, "One sweep"). Being a QR factor it
/// keeps the digits that J'J would square away. Tests:
/// tests/identify/optimizers/levenberg_marquardt_test.cc, conformance_test.cc.

#include "identify/optimizers/problem.h"
#include "identify/optimizers/summary.h"

namespace lipoid {

class LeastSquaresProblem : public OptimizationProblem {
 public:
  /// The (n+1) x (n+1) upper triangular factor of [J r] at x; its last column alone where the
  /// Jacobian is not wanted: the norm of r stands at the bottom right. Not finite where the model
  /// has no value.
  [[nodiscard]] virtual Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const = 0;

  /// 1/2 ||r||².
  [[nodiscard]] double Cost(const Eigen::VectorXd& x) const override {
    return 0.5 * Factor(x, false).rightCols(1).squaredNorm();
  }

  /// J'r, from the factor.
  double Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) const override {
    const Eigen::MatrixXd factor = Factor(x, true);
    gradient = factor.leftCols(x.size()).transpose() * factor.rightCols(1);
    return 0.5 * factor.rightCols(1).squaredNorm();
  }
};

}  // namespace lipoid
