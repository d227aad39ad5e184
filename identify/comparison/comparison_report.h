#pragma once

/// @file
/// A comparison of optimizers as JSON (the keys of `lipoid compare --summary`) and as CSV. Tests:
/// tests/identify/comparison/compare_optimizers_test.cc, tests/tools/compare_test.cc.

#include <string>

#include "identify/comparison/compare_optimizers.h"
#include "model/core/json.h"

namespace lipoid {

/// problem[].{parameter, unit, start, lower, upper, box_upper}, best.{optimizer, cost, tied, fit}, results[].
[[nodiscard]] Json ComparisonToJson(const Comparison& comparison, bool diffusion);

/// A line that begins with # and says by which lipoid, a header with units, and one line per
/// optimizer and start.
[[nodiscard]] std::string ComparisonToCsv(const Comparison& comparison,
                                          const std::string& campaign,
                                          bool diffusion);

}  // namespace lipoid
