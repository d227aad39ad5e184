#pragma once

/// @file
/// Truth against estimate as a table for people.

#include <string>

#include "model/battery/cell_comparison.h"

namespace lipoid {

[[nodiscard]] std::string TruthTable(const CellComparison& comparison);

}  // namespace lipoid
