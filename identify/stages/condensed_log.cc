#include "identify/stages/condensed_log.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "identify/logs/columns.h"
#include "identify/logs/constancy.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

// What the stamps' own rounding may do to an interval that ends at time_s.
double Rounding(double time_s) {
  return 4.0 * std::numeric_limits<double>::epsilon() * std::abs(time_s);
}

}  // namespace

// Lanczos' recurrence on the rows gives the orthonormal polynomials and their Jacobi matrix, whose
// eigenvectors are the quadrature (Golub and Welsch 1969).
BlockShape MakeBlockShape(std::vector<double> offset_s, int nodes) {
  const auto n = static_cast<Eigen::Index>(nodes);
  const auto rows = static_cast<Eigen::Index>(offset_s.size());
  Require(n >= 1 && n <= rows,
          "1 <= nodes <= rows",
          {{"nodes", static_cast<double>(n)}, {"rows", static_cast<double>(rows)}});
  BlockShape shape;
  const double middle = 0.5 * (offset_s.front() + offset_s.back());
  const double half = rows > 1 ? 0.5 * (offset_s.back() - offset_s.front()) : 1.0;
  const Eigen::VectorXd x =
      (Eigen::Map<const Eigen::VectorXd>(offset_s.data(), rows).array() - middle) / half;

  Eigen::MatrixXd jacobi = Eigen::MatrixXd::Zero(n, n);
  shape.basis.resize(rows, n);
  shape.basis.col(0).setConstant(1.0 / std::sqrt(static_cast<double>(rows)));
  for (Eigen::Index m = 0; m < n; ++m) {
    Eigen::VectorXd next = x.cwiseProduct(shape.basis.col(m));
    jacobi(m, m) = shape.basis.col(m).dot(next);
    if (m + 1 == n) break;
    for (int twice = 0; twice < 2; ++twice) {
      const Eigen::VectorXd overlap = shape.basis.leftCols(m + 1).transpose() * next;
      next -= shape.basis.leftCols(m + 1) * overlap;
    }
    jacobi(m + 1, m) = jacobi(m, m + 1) = next.norm();
    shape.basis.col(m + 1) = next / next.norm();
  }
  const SymmetricEigen eigen = EigenOfSymmetric(jacobi);
  shape.node_s = eigen.values.array() * half + middle;
  shape.weight = static_cast<double>(rows) * eigen.vectors.row(0).array().square();
  shape.at_nodes.resize(n, n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const double q0 = eigen.vectors(0, j);
    shape.at_nodes.col(j) = eigen.vectors.col(j) / (q0 * std::sqrt(static_cast<double>(rows)));
  }
  shape.to_rows = shape.basis * (shape.at_nodes * shape.weight.asDiagonal());
  shape.offset_s = std::move(offset_s);
  return shape;
}

CondensedLog::CondensedLog(const Record& record, const Condensation& how) : record_(&record) {
  const std::size_t n = record.size();
  if (how.nodes == 0 || n < 2) {
    AddRows(0, n);
    return;
  }
  const auto& t = record.time_s;
  const auto& i = record.current_A;
  const bool backward = record.hold == Hold::kBackward;
  const auto held = [&](std::size_t row) { return i[backward ? row : row - 1]; };
  double tolerance_A = 0.0;
  if (how.coarse) {
    // Rows of one level differ by their noise: six deviations, or a noisy log would not get short.
    tolerance_A = std::max(1e-3 * LargestMagnitude(i), 6.0 * RowNoise(i, 0, n - 1));
  }

  AddRows(0, 1);
  std::size_t changed = 0;  // the current has been level_A since this row
  double level_A = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 1; k < n;) {
    if (!(std::abs(held(k) - level_A) <= tolerance_A)) {
      level_A = held(k);
      changed = k - 1;
    }
    // Rows [k, end) see this current only, and are evenly spaced or need not be.
    const double interval_s = t[k] - t[k - 1];
    std::size_t end = k;
    bool even = true;
    while (end < n && std::abs(held(end) - level_A) <= tolerance_A &&
           std::abs(i[end] - level_A) <= tolerance_A) {
      if (std::abs(t[end] - t[end - 1] - interval_s) > Rounding(t[end])) {
        if (!how.coarse) break;
        even = false;
      }
      ++end;
    }
    if (end == k) {
      AddRows(k++, 1);
      continue;
    }
    while (k < end) {
      StopIfAsked();
      const double age_s = t[k - 1] - t[changed];
      const auto fits = [&](std::size_t rows) {
        const double growth = rows > how.late_block ? how.late_growth : how.growth;
        return t[k - 1 + rows] - t[k - 1] <= growth * age_s;
      };
      // Powers of two, so that few shapes serve all.
      std::size_t rows = std::bit_floor(std::min(end - k, how.most_rows));
      while (rows >= how.least_rows && !fits(rows)) rows /= 2;
      if (rows < how.least_rows) {
        AddRows(k++, 1);
        continue;
      }
      AddBlock(k, rows, even, how.nodes);
      k += rows;
    }
  }
  ReadVoltages();
}

void CondensedLog::AddRows(std::size_t first, std::size_t rows) {
  if (!pieces_.empty() && pieces_.back().plain()) {
    pieces_.back().rows += rows;
    return;
  }
  CondensedPiece piece;
  piece.first = first;
  piece.rows = rows;
  pieces_.push_back(piece);
}

void CondensedLog::AddBlock(std::size_t first, std::size_t rows, bool even, int nodes) {
  const auto& t = record_->time_s;
  CondensedPiece piece;
  piece.first = first;
  piece.rows = rows;
  const double before_s = t[first - 1];
  const double end_s = t[first + rows - 1];
  piece.duration_s = end_s - before_s;
  const auto shared =
      std::find_if(even_shapes_.begin(), even_shapes_.end(), [&](std::size_t shape) {
        return even && shapes_[shape].rows() == rows &&
               std::abs(shapes_[shape].duration_s() - piece.duration_s) <= 2.0 * Rounding(end_s);
      });
  if (shared != even_shapes_.end()) {
    piece.shape = *shared;
  } else {
    std::vector<double> offset_s(rows);
    for (std::size_t k = 0; k < rows; ++k) {
      offset_s[k] = even ? piece.duration_s * static_cast<double>(k + 1) / static_cast<double>(rows)
                         : t[first + k] - before_s;
    }
    piece.shape = shapes_.size();
    shapes_.push_back(MakeBlockShape(std::move(offset_s), nodes));
    if (even) even_shapes_.push_back(piece.shape);
  }
  // The mean over time, where rows differ by noise.
  const bool backward = record_->hold == Hold::kBackward;
  const auto held = [&](std::size_t row) { return record_->current_A[backward ? row : row - 1]; };
  piece.current_A = held(first);
  double excess_C = 0.0;
  for (std::size_t k = first; k < first + rows; ++k) {
    excess_C += (held(k) - piece.current_A) * (t[k] - t[k - 1]);
  }
  piece.current_A += excess_C / piece.duration_s;
  piece.voltages = node_voltage_V_.size();
  node_voltage_V_.resize(node_voltage_V_.size() + static_cast<std::size_t>(nodes));
  pieces_.push_back(piece);
}

// Fits a polynomial to the voltages of every block.
void CondensedLog::ReadVoltages() {
  if (record_->voltage_V.empty()) return;
  ParallelFor(pieces_.size(), [&](std::size_t p) {
    CondensedPiece& piece = pieces_[p];
    if (piece.plain()) return;
    const BlockShape& shape = shapes_[piece.shape];
    const auto rows = static_cast<Eigen::Index>(piece.rows);
    const double* voltage_V = record_->voltage_V.data() + piece.first;
    // From the first voltage, or the squares would cancel.
    const Eigen::VectorXd v =
        Eigen::Map<const Eigen::VectorXd>(voltage_V, rows).array() - voltage_V[0];
    const Eigen::VectorXd coefficients = shape.basis.transpose() * v;
    piece.remainder = v.squaredNorm() - coefficients.squaredNorm();
    if (piece.remainder < 1e-6 * v.squaredNorm())  // the difference has lost digits
      piece.remainder = (v - shape.basis * coefficients).squaredNorm();
    Eigen::Map<Eigen::VectorXd>(node_voltage_V_.data() + piece.voltages, shape.nodes()) =
        (shape.at_nodes.transpose() * coefficients).array() + voltage_V[0];
  });
}

std::size_t CondensedLog::points() const {
  std::size_t points = 0;
  for (const CondensedPiece& piece : pieces_) {
    points += piece.plain() ? piece.rows : static_cast<std::size_t>(shapes_[piece.shape].nodes());
  }
  return points;
}

}  // namespace lipoid
