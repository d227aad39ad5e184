#pragma once

/// @file
/// A log in which stretches of constant current are said in fewer numbers.
///
/// While the current is constant every voltage of the model is a sum of exponentials in time, the
/// slower the longer ago the current changed: over a block of N rows it is a polynomial p of low
/// degree. For polynomials of degree < n (nodes) on the N rows t_k with measured voltages v_k
///
///   sum_k (v_k - p(t_k))² = sum_j w_j (y_j - p(x_j))² + rho²
///
/// with the nodes x_j and weights w_j of the Gaussian quadrature of the rows, y the values at x_j
/// of the polynomial that fits v best, and rho² what that one leaves. n evaluations of the model
/// stand for N, exactly, whatever the noise in v.
///
/// A block is short beside the time since the current changed. With growth 0.16 and 8 nodes the
/// remainder of any mode e^{-lambda t} is below 2e-12 of its amplitude (docs/theory.md, "Fewer
/// rows"). Curves v_oc(A) of pieces are polynomials only within a piece: where a block crosses a knot
/// the sweep takes its rows one by one, with A and the branches from their polynomials. Tests:
/// tests/identify/stages/condensed_log_test.cc.

#include <Eigen/Core>
#include <cstddef>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

/// N rows at offsets from the row before the block, by which polynomials on them are known.
struct BlockShape {
  std::vector<double> offset_s;  ///< of the rows
  Eigen::VectorXd node_s;        ///< x_j, rising
  Eigen::VectorXd weight;        ///< w_j; their sum is N
  Eigen::MatrixXd basis;         ///< N x n: orthonormal polynomials on the rows
  Eigen::MatrixXd at_nodes;      ///< n x n: the same polynomials at the nodes
  Eigen::MatrixXd to_rows;       ///< N x n: a polynomial on the rows from its values at the nodes

  [[nodiscard]] std::size_t rows() const { return offset_s.size(); }
  [[nodiscard]] Eigen::Index nodes() const { return node_s.size(); }
  [[nodiscard]] double duration_s() const { return offset_s.back(); }
};

/// Rising positive offsets; 1 <= nodes <= their number.
[[nodiscard]] BlockShape MakeBlockShape(std::vector<double> offset_s, int nodes);

struct Condensation {
  /// Nodes of a block; 0: every row stays as it is.
  int nodes = 8;
  /// Length of a block over the time since the current changed.
  double growth = 0.16;
  /// The same for blocks of more rows than late_block, so that few blocks cross a knot of v_oc(A).
  double late_growth = 0.05;
  std::size_t late_block = 64;
  std::size_t least_rows = 32;  ///< shorter blocks gain nothing
  std::size_t most_rows = 4096;
  /// Currents that differ by noise count as constant, uneven sampling does not matter, and knots of
  /// v_oc(A) are smoothed over: for comparing starts and for global searches, never for answers.
  bool coarse = false;

  [[nodiscard]] static Condensation None() { return {.nodes = 0}; }
  [[nodiscard]] static Condensation Exact() { return {}; }
  [[nodiscard]] static Condensation Coarse() {
    return {.nodes = 3, .growth = 0.5, .late_growth = 0.5, .least_rows = 4, .coarse = true};
  }
};

/// What follows row `first - 1`: a block, or plain rows.
struct CondensedPiece {
  static constexpr std::size_t kPlainRows = static_cast<std::size_t>(-1);

  std::size_t first = 0;
  std::size_t rows = 0;
  std::size_t shape = kPlainRows;  ///< index in shapes()
  double current_A = 0.0;          ///< of every row of the block
  double duration_s = 0.0;         ///< by the stamps themselves
  double remainder = 0.0;          ///< rho²
  std::size_t voltages = 0;        ///< where its y_0 stands

  [[nodiscard]] bool plain() const { return shape == kPlainRows; }
};

class CondensedLog {
 public:
  /// The record must outlive this.
  CondensedLog(const Record& record, const Condensation& how);

  [[nodiscard]] const Record& record() const { return *record_; }
  [[nodiscard]] const std::vector<CondensedPiece>& pieces() const { return pieces_; }
  [[nodiscard]] const std::vector<BlockShape>& shapes() const { return shapes_; }
  [[nodiscard]] const double* node_voltage_V(const CondensedPiece& piece) const {
    return node_voltage_V_.data() + piece.voltages;
  }
  /// Rows and nodes on which the model is evaluated where no knot comes in between.
  [[nodiscard]] std::size_t points() const;

 private:
  void AddRows(std::size_t first, std::size_t rows);
  void AddBlock(std::size_t first, std::size_t rows, bool even, int nodes);
  void ReadVoltages();

  const Record* record_;
  std::vector<CondensedPiece> pieces_;
  std::vector<BlockShape> shapes_;
  std::vector<std::size_t> even_shapes_;  // those that other blocks may share
  std::vector<double> node_voltage_V_;
};

}  // namespace lipoid
