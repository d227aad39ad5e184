#pragma once

/// @file
/// What is in a log, as JSON: `lipoid inspect --summary` (docs/formats.md).
/// Tests: tests/tools/inspect_test.cc, and the schemas of docs/schemas.

#include "identify/logs/inspection.h"
#include "model/core/json.h"

namespace lipoid {

[[nodiscard]] Json InspectionToJson(const Inspection& log);

/// What reading a log dropped, where its gaps are, warnings and notes: keys of --summary that commands
/// share.
[[nodiscard]] Json ReadingToJson(const LogReport& report);

}  // namespace lipoid
