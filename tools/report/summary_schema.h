#pragma once

/// @file
/// Whether a JSON file is what `--summary` of a command writes: docs/schemas, which is built into
/// the program. A summary from elsewhere is input like any other, and the views of the page rely on
/// the types of its values. Tests: tests/tools/report_command_test.cc.

#include <string>
#include <string_view>
#include <vector>

#include "model/core/json.h"

namespace lipoid {

/// The commands whose results can be shown, sorted.
[[nodiscard]] std::vector<std::string> CommandsWithReport();

/// Reads a summary. LoadError with file, line and column where it is none: another file, that of a
/// command without a report, a key that is missing, a value of another type. Null stands for any
/// number, since JSON has no infinity. Keys that the schema does not know are passed over.
[[nodiscard]] Json ReadSummary(const std::string& file);

}  // namespace lipoid
