#pragma once

/// @file
/// Closed-loop poles in a summary: of `lipoid poles`, and of the gains that `lipoid design` finds.

#include "model/analysis/poles.h"
#include "model/core/json.h"

namespace lipoid {

/// xi, kappa, and the poles of the three ways as pairs of real and imaginary part, in 1/s.
[[nodiscard]] Json PolesRowToJson(const PolesRow& row);

}  // namespace lipoid
