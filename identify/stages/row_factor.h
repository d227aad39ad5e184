#pragma once

/// @file
/// Accumulates the triangular factor R of a tall matrix, row by row: R'R = sum of the rows' outer
/// products, without ever forming them. Memory does not grow with the rows. Tests:
/// tests/identify/stages/row_factor_test.cc.

#include <Eigen/Core>

#include "model/statistics/factorizations.h"

namespace lipoid {

class RowFactor {
 public:
  explicit RowFactor(int columns)
      : columns_(columns),
        filled_(columns),
        block_(Eigen::MatrixXd::Zero(columns + kRows, columns)) {}

  /// Where the next row goes: write entry j to data[j * stride()], then call Push().
  [[nodiscard]] double* NextRow() { return block_.data() + filled_; }
  [[nodiscard]] Eigen::Index stride() const { return block_.rows(); }
  void Push() {
    if (++filled_ == block_.rows()) Reduce();
  }

  /// Upper triangular, columns x columns.
  [[nodiscard]] Eigen::MatrixXd Factor() {
    Reduce();
    return block_.topRows(columns_);
  }

 private:
  static constexpr Eigen::Index kRows = 256;

  // Householder QR of [R; new rows]: R becomes the factor of all rows so far.
  void Reduce() {
    if (filled_ == columns_) return;
    block_.topRows(columns_) = TriangularFactor(block_.topRows(filled_));
    filled_ = columns_;
  }

  int columns_;
  Eigen::Index filled_;  // rows of block_ in use; the first columns_ hold R
  Eigen::MatrixXd block_;
};

}  // namespace lipoid
