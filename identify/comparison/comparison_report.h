#pragma once

/// @file
/// A comparison of optimizers as JSON (the keys of `lipoid compare --summary`) and as CSV. Tests:
/// tests/identify/comparison/compare_optimizers_test.cc, tests/tools/compare_test.cc.

#include <string>

#include "identify/comparison/compare_optimizers.h"
#include "model/core/json.h"

namespace lipoid {

/// problem[].{parameter, unit, start, lower, upper, box_upper}, best.{optimizer, cost}, results[].
[[nodiscard]] Json ComparisonToJson(const Comparison& comparison, bool diffusion);

/// One line per optimizer.
[[nodiscard]] std::string ComparisonToCsv(const Comparison& comparison, bool diffusion);

}  // namespace lipoid
