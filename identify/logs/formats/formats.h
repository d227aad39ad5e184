#pragma once

/// @file
/// The only list of log formats, and the recognition of a file by its content.
/// To add a format: a Layout in identify/logs/formats/ and a row in formats.cc.
/// Tests: tests/identify/logs/formats/formats_test.cc.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/csv/table_reader.h"
#include "identify/logs/csv/text_source.h"
#include "identify/logs/formats/layout.h"
#include "identify/logs/log.h"

namespace lipoid {

/// All formats, sorted by name.
[[nodiscard]] std::span<const Layout* const> LogFormats();

/// Which column of the table holds a quantity, and what its numbers mean.
struct PlannedColumn {
  std::size_t column = 0;  ///< of TableSpec::columns
  Unit unit;
  std::size_t header_column = 1;  ///< for messages
  std::string header_text = {};
};

/// How one file will be read.
struct LogPlan {
  const Layout* layout = nullptr;
  TableSpec table;
  std::array<std::optional<PlannedColumn>, kQuantityCount> columns;
  std::size_t header_line = 1;
  bool clock_restarts_with_step = false;  ///< the time column is Layout::step_clock
  bool volts_or_millivolts = false;       ///< Layout::millivolts_beside: the values decide
  std::vector<std::string> notes;

  [[nodiscard]] const std::optional<PlannedColumn>& Of(Quantity quantity) const {
    return columns[static_cast<std::size_t>(quantity)];
  }
};

/// Recognises the file, resolves its columns and units, and leaves the source at the first line
/// after the header. LoadError with a position and advice where that cannot be done.
[[nodiscard]] LogPlan PlanReading(TextSource& source, const ReadOptions& options);

}  // namespace lipoid
