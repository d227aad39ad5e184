#pragma once

/// @file
/// How stable the loops of a controller are, in a summary: of `lipoid fly` and `lipoid design`.

#include <span>

#include "model/analysis/stability.h"
#include "model/core/json.h"

namespace lipoid {

/// One object for each loop at each hover; null where a number does not exist.
[[nodiscard]] Json StabilityToJson(std::span<const HoverStability> hovers);

}  // namespace lipoid
