#pragma once

/// @file
/// The middle of numbers in no order. Tests: tests/identify/median_test.cc.

#include <algorithm>
#include <limits>
#include <vector>

namespace lipoid {

/// The middle value, of an even number of them the upper of the middle two: one that occurs. NaN of
/// none.
inline double UpperMedian(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// The middle value, or the mean of the middle two; NaN of none.
inline double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(values.begin(), values.end());
  return 0.5 * (values[(values.size() - 1) / 2] + values[values.size() / 2]);
}

}  // namespace lipoid
