#pragma once

/// @file
/// A straight line through the logarithms of what flights say of one quantity, in their order: the same share is
/// lost in every flight, and never more than all. Tests:
/// tests/identify/health/trend_test.cc.

#include <cstddef>
#include <limits>
#include <optional>
#include <span>
#include <string>

namespace lipoid {

/// A number with its 95 % interval; not finite where the flights do not tell.
struct WithInterval {
  double value = std::numeric_limits<double>::quiet_NaN();
  double low = std::numeric_limits<double>::quiet_NaN();
  double high = std::numeric_limits<double>::quiet_NaN();
  std::string unknown_because;  ///< one sentence where it is not known
  [[nodiscard]] bool known() const { return unknown_because.empty(); }
};

struct HealthTrend {
  std::size_t flights = 0;  ///< that tell the quantity
  WithInterval first;       ///< of the line, at the first of them
  WithInterval last;
  WithInterval change_percent;      ///< from the first to the last
  WithInterval per_flight_percent;  ///< of the first, on average
};

/// What one flight says: its place in the order, the quantity (> 0) and the standard deviation of its
/// logarithm.
struct TrendPoint {
  double at = 0.0;
  double value = 0.0;
  double log_deviation = 1.0;
};

/// Weighted by their deviations; how far off the line the points really scatter gives the intervals.
/// An error that all flights share in proportion is not in the scatter, and cancels in a change. One
/// that grows with the quantity does not: a pack that warms less than a typical one seems to gain less
/// resistance than it does. None from fewer than three points.
[[nodiscard]] std::optional<HealthTrend> FitTrend(std::span<const TrendPoint> points);

}  // namespace lipoid
