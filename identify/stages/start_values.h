#pragma once

/// @file
/// Where stage 3 starts, read off the data: steps of the current show the series resistance, the
/// voltage after a load is switched off shows time constants. Tests:
/// tests/identify/stages/start_values_test.cc.

#include <limits>
#include <vector>

#include "identify/logs/record.h"
#include "identify/logs/segments.h"

namespace lipoid {

struct StartValues {
  /// Median of -dv/di over the steps of the current that the sampling resolves best; NaN without a
  /// step.
  double series_resistance_Ohm = std::numeric_limits<double>::quiet_NaN();
  /// Median time to 63 % of the recovery seen in each rest after a load; NaN without one.
  double relaxation_s = std::numeric_limits<double>::quiet_NaN();
  /// Median recovery per ampere of the load before; NaN without one.
  double relaxation_Ohm = std::numeric_limits<double>::quiet_NaN();
  /// The shortest interval between rows at a step, and the longest rest: the time constants that
  /// the log can show lie between them.
  double shortest_s = 1.0;
  double longest_s = 4.0;
};

/// `segments`: those of FindSegments() for each record where they are known, or none.
[[nodiscard]] StartValues FindStartValues(const std::vector<const Record*>& records,
                                          const std::vector<std::vector<Segment>>& segments = {});

}  // namespace lipoid
