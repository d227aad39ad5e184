#pragma once

/// @file
/// What an export says of itself, as JSON: `lipoid export --summary` (docs/formats.md).
/// Tests: tests/tools/export_test.cc.

#include <string>

#include "identify/export/targets.h"
#include "model/core/json.h"

namespace lipoid {

/// All keys but `files`.
[[nodiscard]] Json ExportToJson(const ExportTarget& target,
                                const ExportRequest& request,
                                const Exported& exported);

/// What the law of this file is to the cell's: that of its target (TargetKind), but for an exact one that leaves
/// something out. The first is for people, the second, "incomplete" in this case, the key `kind`.
struct ExportKind {
  std::string words;
  std::string key;
};
[[nodiscard]] ExportKind KindOfExport(const ExportTarget& target,
                                      const ExportRequest& request,
                                      const Exported& exported);

/// "beside it, with its stem": dir/frame.json and ".parm" are dir/frame.parm.
[[nodiscard]] std::string FileBeside(const std::string& output, const std::string& suffix);

}  // namespace lipoid
