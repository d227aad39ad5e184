#pragma once

/// @file
/// From a header to the columns that are read: which holds a quantity, in which unit, and how its
/// cells are written.
/// Tests: tests/identify/logs/formats/formats_test.cc, tests/identify/logs/log_test.cc.

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/csv/table_reader.h"
#include "identify/logs/formats/find_header.h"

namespace lipoid {

/// Which column of the table holds a quantity, and what its numbers mean.
struct PlannedColumn {
  std::size_t column = 0;  ///< of TableSpec::columns
  Unit unit;
  std::size_t header_column = 1;  ///< for messages
  std::string header_text = {};
  /// Each number of the first rows may be one with a mark for thousands: 4.180, 12,345.
  bool in_thousands = false;
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
  std::vector<std::string> warnings;  ///< for LogReport::warnings

  [[nodiscard]] const std::optional<PlannedColumn>& Of(Quantity quantity) const {
    return columns[static_cast<std::size_t>(quantity)];
  }
};

/// Resolves columns and units by the header and the first rows below it, and leaves the source at
/// the first line to read. LoadError with a position and advice where that cannot be done.
[[nodiscard]] LogPlan PlanColumns(TextSource& source,
                                  const ReadOptions& options,
                                  FoundHeader header,
                                  const std::vector<HeadLine>& lines);

}  // namespace lipoid
