#pragma once

/// @file
/// Sums and extremes over the rows of a log, which may be millions.
///
/// Rows are taken in pieces of a fixed size, side by side, and each piece in four strands, so that
/// no addition waits for the one before: such passes cost what reading the columns costs. Pieces
/// are joined in order: the same bits with any number of threads. Tests:
/// tests/identify/logs/columns_test.cc.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "identify/logs/record.h"

namespace lipoid {

struct Extent {
  double least = std::numeric_limits<double>::infinity();
  double most = -std::numeric_limits<double>::infinity();

  /// 0 of no values.
  [[nodiscard]] double Magnitude() const {
    return least <= most ? std::max(std::abs(least), std::abs(most)) : 0.0;
  }
};

/// Infinite, the wrong way round, for no values.
[[nodiscard]] Extent FindExtent(std::span<const double> values);

/// 0 for no values.
[[nodiscard]] double LargestMagnitude(std::span<const double> values);

[[nodiscard]] double Sum(std::span<const double> values);

/// The least difference of neighbours; infinite for less than two values.
[[nodiscard]] double ShortestInterval(std::span<const double> time_s);

/// The charge that leaves between two rows, and the extremes of the sum on the way, 0 among them.
struct ChargeMoved {
  double charge_C = 0.0;
  double least_C = 0.0;
  double most_C = 0.0;

  /// Between the fullest and the emptiest moment.
  [[nodiscard]] double range_C() const { return most_C - least_C; }
  /// What comes after this.
  void Append(const ChargeMoved& next);
};

/// By the hold of the record, (4.59); from <= to < size.
[[nodiscard]] ChargeMoved CountCharge(const Record& record, std::size_t from, std::size_t to);
/// The same of all rows, of which there is at least one.
[[nodiscard]] inline ChargeMoved CountCharge(const Record& record) {
  return CountCharge(record, 0, record.size() - 1);
}

}  // namespace lipoid
