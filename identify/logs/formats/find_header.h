#pragma once

/// @file
/// The header of a log: which line names its columns, in which format.
/// Tests: tests/identify/logs/formats/formats_test.cc, tests/identify/logs/log_test.cc.

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/csv/text_source.h"
#include "identify/logs/formats/header.h"
#include "identify/logs/formats/layout.h"
#include "identify/logs/log.h"
#include "model/core/text_cells.h"

namespace lipoid {

/// A line of the head of a file.
struct HeadLine {
  std::string_view text;  ///< without its line end
  std::size_t next = 0;   ///< offset of the line after it
};

/// As many lines as a header and what stands above it may take.
[[nodiscard]] std::vector<HeadLine> HeadLines(std::string_view head, char line_end);

[[nodiscard]] std::vector<TextCell> CellsOf(std::string_view line, char delimiter);

/// A header that was found: in which line, in which format.
struct FoundHeader {
  const Layout* layout = nullptr;
  char delimiter = ',';
  std::size_t line = 1;  ///< number of the header's line; of the first row where it is implied
  bool implied = false;
  /// Rows of numbers follow, so that the user's names may be numbers of columns.
  bool numbered = false;
  std::vector<HeaderName> names = {};                ///< of the rows' level, its indent included
  std::vector<std::vector<HeaderName>> levels = {};  ///< above it

  /// The columns that go by the user's name for a quantity, or by the usual ones.
  [[nodiscard]] std::vector<HeaderMatch> Find(Quantity quantity, const ReadOptions& options) const;
};

/// Of a text without rows of numbers, or of a table that has one of time, current and voltage at most: it is no
/// log, rather than one that cannot be read.
class NoLogError : public LoadError {
 public:
  using LoadError::LoadError;
};

/// The first line that is the header of one of `formats`, or that names time, current and voltage.
/// LoadError with advice where no line does, a NoLogError where this is no log.
[[nodiscard]] FoundHeader FindHeader(const TextSource& source,
                                     const std::vector<HeadLine>& lines,
                                     std::span<const Layout* const> formats,
                                     const ReadOptions& options);

/// The names of columns for a message.
[[nodiscard]] std::string Listed(const std::vector<HeaderName>& names);

}  // namespace lipoid
