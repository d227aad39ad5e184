#pragma once

/// @file
/// What the run record of a cell says of the fit that made it.
/// Tests: tests/model/battery/fit_record_test.cc.

#include <string>

#include "model/battery/cell.h"
#include "model/core/json.h"

namespace lipoid {

/// A member of the run record's metrics; null where there is none.
[[nodiscard]] const Json& FitMetric(const Cell& cell, const char* key);

/// Whether `identify` found that the cell does not describe its own logs.
[[nodiscard]] bool IsOfPoorFit(const Cell& cell);

/// Why whatever is computed from the cell is doubtful, as a sentence. "": its fit says nothing against it.
[[nodiscard]] std::string DoubtAboutFit(const Cell& cell);

}  // namespace lipoid
