#pragma once

/// @file
/// What a fit needs to know of all rows at given rates: the least squares of the linear unknowns,
/// and, at a value of them, how the residuals move with the rates.
/// Tests: tests/identify/joint/joint_sweep_test.cc, tests/identify/stages/voltage_sweep_test.cc.

#include <Eigen/Core>

#include "identify/fit/cell_rows.h"

namespace lipoid {

/// sum w (y - a'x)² = square - 2 right'x + x' matrix x over rows, with y counted from the reference
/// curve, which keeps the sums from cancelling. Only the lower triangle of the matrix is filled.
struct NormalEquations {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd right;
  double square = 0.0;
  double weight = 0.0;

  explicit NormalEquations(int n = 0)
      : matrix(Eigen::MatrixXd::Zero(n, n)), right(Eigen::VectorXd::Zero(n)) {}
  void Add(double w, const CellRow& row) {
    weight += w;
    square += w * row.y * row.y;
    for (int b = 0; b < row.entries; ++b) {
      const double wb = w * row.value[b];
      right[row.index[b]] += wb * row.y;
      double* column = matrix.col(row.index[b]).data();
      for (int a = b; a < row.entries; ++a) column[row.index[a]] += wb * row.value[a];
    }
  }
  void Add(const NormalEquations& other, double sign = 1.0) {
    matrix += sign * other.matrix;
    right += sign * other.right;
    square += sign * other.square;
    weight += sign * other.weight;
  }
  /// The sum at x.
  [[nodiscard]] double At(const Eigen::VectorXd& x) const {
    return square - 2.0 * right.dot(x) + x.dot(matrix.selfadjointView<Eigen::Lower>() * x);
  }
};

/// What the slopes S of the predicted voltage in the nonlinear parameters (RateSlots) sum to at the
/// unknowns x, with the residual r = y - a'x. The sums of r itself have the digits that those of y
/// lose where the fit is much smaller than the drops.
struct SlopeSums {
  Eigen::MatrixXd of_rates;       ///< sum w S S'
  Eigen::VectorXd with_residual;  ///< sum w S r
  Eigen::MatrixXd with_linear;    ///< sum w S a'
  Eigen::VectorXd right;          ///< sum w r a
  double square = 0.0;            ///< sum w r²

  explicit SlopeSums(int rates = 0, Eigen::Index linear = 0)
      : of_rates(Eigen::MatrixXd::Zero(rates, rates)),
        with_residual(Eigen::VectorXd::Zero(rates)),
        with_linear(Eigen::MatrixXd::Zero(rates, linear)),
        right(Eigen::VectorXd::Zero(linear)) {}
  void Add(double w, const CellRow& row, const double* x) {
    const Eigen::Map<const Eigen::VectorXd> slope(row.slope, with_residual.size());
    const double residual_V = row.Residual(x);
    for (int e = 0; e < row.entries; ++e) {
      const double wa = w * row.value[e];
      with_linear.col(row.index[e]) += wa * slope;
      right[row.index[e]] += wa * residual_V;
    }
    of_rates.noalias() += w * slope * slope.transpose();
    with_residual += w * residual_V * slope;
    square += w * residual_V * residual_V;
  }
  void Add(const SlopeSums& other) {
    of_rates += other.of_rates;
    with_residual += other.with_residual;
    with_linear += other.with_linear;
    right += other.right;
    square += other.square;
  }
};

}  // namespace lipoid
