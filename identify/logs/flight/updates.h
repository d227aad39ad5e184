#pragma once

/// @file
/// How often a logged value really changes: an autopilot repeats the last value of a slower sensor in
/// every row. Tests: tests/identify/logs/flight/flight_log_test.cc.

#include <span>
#include <vector>

#include "model/statistics/order_statistics.h"

namespace lipoid {

/// The median time between rows; 0 with fewer than two.
[[nodiscard]] inline double MedianInterval(std::span<const double> time_s) {
  std::vector<double> intervals;
  for (std::size_t k = 1; k < time_s.size(); ++k) intervals.push_back(time_s[k] - time_s[k - 1]);
  return intervals.empty() ? 0.0 : Median(std::move(intervals));
}

/// The median time between two rows at which the value is another than in the row before; that
/// between rows where it never changes twice. A value that is at rest changes seldom: of a log most of which is at rest this says too
/// much, so that only rows count after which the value moves within kAtRest rows.
[[nodiscard]] inline double UpdateInterval(std::span<const double> time_s,
                                           std::span<const double> values) {
  constexpr std::size_t kAtRest = 20;
  std::vector<double> intervals;
  std::size_t last = 0;
  for (std::size_t k = 1; k < values.size(); ++k) {
    if (values[k] == values[k - 1]) continue;
    if (last > 0 && k - last <= kAtRest) intervals.push_back(time_s[k] - time_s[last]);
    last = k;
  }
  return intervals.empty() ? MedianInterval(time_s) : Median(std::move(intervals));
}

/// Rows with a new value; while the value stays the same longer than its update, a row each update.
[[nodiscard]] inline std::vector<std::size_t> FreshRows(std::span<const double> time_s,
                                                        std::span<const double> values,
                                                        double update_s) {
  std::vector<std::size_t> rows;
  const bool staircase = update_s > 1.5 * MedianInterval(time_s);
  for (std::size_t k = 0; k < values.size(); ++k) {
    const bool changed = k == 0 || values[k] != values[k - 1];
    if (staircase && !changed && time_s[k] - time_s[rows.back()] < 1.2 * update_s) continue;
    rows.push_back(k);
  }
  return rows;
}

}  // namespace lipoid
