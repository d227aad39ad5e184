#pragma once

/// @file
/// The middle of numbers in no order, and the value that has so many below it. Tests:
/// tests/model/statistics/order_statistics_test.cc.

#include <algorithm>
#include <cstddef>
#include <limits>
#include <vector>

namespace lipoid {

/// The value that has `place` values before it in order, place < size. Changes the order of the
/// values.
inline double ValueAtPlace(std::vector<double>& values, std::size_t place) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(place);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// The middle value, of an even number of them the upper of the middle two: one that occurs. NaN of
/// none.
inline double UpperMedian(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  return ValueAtPlace(values, values.size() / 2);
}

/// The middle value, or the mean of the middle two; NaN of none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const std::size_t middle = values.size() / 2;
  const double upper = ValueAtPlace(values, middle);
  if (values.size() % 2 == 1) return upper;
  // All before the middle are at most as large now; sorting millions of rows would take long.
  const auto end = values.begin() + static_cast<std::ptrdiff_t>(middle);
  return 0.5 * (*std::max_element(values.begin(), end) + upper);
}

}  // namespace lipoid
