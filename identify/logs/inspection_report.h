#pragma once

/// @file
/// What is in a log, as JSON and for people: `lipoid inspect --summary` (docs/formats.md).
/// Tests: tests/tools/inspect_test.cc, and the schemas of docs/schemas.

#include "identify/logs/inspection.h"
#include "model/core/json.h"

namespace lipoid {

[[nodiscard]] Json InspectionToJson(const Inspection& log);

/// What reading a log dropped, where its gaps are, warnings and notes: keys of --summary that commands
/// share.
[[nodiscard]] Json ReadingToJson(const LogReport& report);

/// "1 row with a repeated time stamp, 12 rows outside the chosen part"; "" where nothing was dropped.
[[nodiscard]] std::string DroppedText(const LogReport& report);

}  // namespace lipoid
