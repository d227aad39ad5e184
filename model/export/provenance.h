#pragma once

/// @file
/// What every exported file says of itself in its comments: from which cell, over which mission,
/// how far its law is from the cell, what it cannot hold. Tests:
/// tests/model/export/provenance_test.cc.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "model/core/foreign_text.h"
#include "model/export/exported.h"

namespace lipoid {

/// Text that came from elsewhere, escaped and shortened, without a character that could end or
/// continue a comment in any of the targets' languages.
[[nodiscard]] std::string HarmlessInComment(std::string_view text,
                                            std::size_t most_bytes = kMostBytesOfValue);

/// " without its temperature and hysteresis", of a law that is the cell's own but for what no target holds; ""
/// where the cell has neither.
[[nodiscard]] std::string WithoutWhatNoTargetHolds(const ExportRequest& request);

/// ", but that ...": how a step of the cell's own law depends on its length; "" where it does not.
[[nodiscard]] std::string ButForTables(const Cell& cell);

/// The lines, without comment signs; text that came from elsewhere is escaped and shortened, and no
/// line has a character that could end a comment (a line break, "*/", "-->", "#}"). `exported` has
/// everything but its files.
[[nodiscard]] std::vector<std::string> ProvenanceLines(const ExportRequest& request,
                                                       const Exported& exported);

/// Within so many bytes of its begin a file says who made it.
inline constexpr std::size_t kProvenanceBytes = 4000;
/// Whether the file that begins so is an export of lipoid.
[[nodiscard]] bool HasProvenance(std::string_view begin);

/// The lines, each after `sign` ("# ") and before a line break; lines wrap at 100 columns.
[[nodiscard]] std::string Commented(const std::vector<std::string>& lines, std::string_view sign);

}  // namespace lipoid
