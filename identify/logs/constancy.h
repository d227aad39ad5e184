#pragma once

/// @file
/// Does a stretch of a record keep to one current?
///
/// It counts as constant unless more than kMaxChargeOffMedian of its charge flows at a current that
/// is over kOffMedian away from the median (over time). Where the noise of the rows alone would
/// reach that far, the current is averaged over as many rows as it takes to see through it. Tests:
/// tests/identify/logs/constancy_test.cc.

#include <cstddef>
#include <span>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

inline constexpr double kOffMedian = 0.10;
inline constexpr double kMaxChargeOffMedian = 0.05;

struct Constancy {
  double median_A = 0.0;           ///< over time, by the hold of the record
  double charge_off_median = 0.0;  ///< share of the charge (of either sign) that flows far from it

  [[nodiscard]] bool constant() const { return charge_off_median <= kMaxChargeOffMedian; }
};

/// Of rows [first, last], both included.
[[nodiscard]] Constancy MeasureConstancy(const Record& record, std::size_t first, std::size_t last);

/// Standard deviation of the noise of values [first, last], from the distance of each to the median
/// of itself and its neighbours: steps, slopes and the repeats of a coarse instrument leave it
/// alone.
[[nodiscard]] double RowNoise(std::span<const double> values, std::size_t first, std::size_t last);

/// How long the current of row k flows, by the hold of the record; 0 for the one row that moves no
/// charge.
[[nodiscard]] inline double RowDuration(const Record& record, std::size_t k) {
  const auto& t = record.time_s;
  if (record.hold == Hold::kBackward) return k == 0 ? 0.0 : t[k] - t[k - 1];
  return k + 1 == t.size() ? 0.0 : t[k + 1] - t[k];
}

}  // namespace lipoid
