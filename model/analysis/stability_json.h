#pragma once

/// @file
/// How stable the loops of a controller are, in a summary: of `lipoid fly`, of `lipoid design` and of
/// lipoid.fly(). Tests: tests/tools/, tests/python/test_flight.py.

#include <span>

#include "model/analysis/stability.h"
#include "model/core/json.h"

namespace lipoid {

/// One object for each loop at each hover; null where a number does not exist.
[[nodiscard]] Json StabilityToJson(std::span<const HoverStability> hovers);

}  // namespace lipoid
