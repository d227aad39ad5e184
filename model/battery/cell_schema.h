#pragma once

/// @file
/// The JSON Schema (draft 2020-12) of the cell file: what ParseCell() asks of keys, types and
/// ranges. What a schema cannot say, that lists are of one length or rise, only the reader checks.
/// docs/schemas/cell.schema.json is this. Tests: tests/tools/schemas_test.py.

#include "model/core/json.h"

namespace lipoid {

[[nodiscard]] Json CellSchema();

}  // namespace lipoid
