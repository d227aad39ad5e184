#pragma once

/// @file
/// One log format, declared: how its header is known and what its columns are called. Every format
/// is read by the same engine; a format adds names, not code.

#include <array>
#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "identify/logs/csv/times.h"
#include "identify/logs/formats/quantity.h"
#include "model/battery/record_stepper.h"
#include "model/core/text_cells.h"

namespace lipoid {

/// Names of one column in lower case, blanks as '_', without the unit.
struct ColumnNames {
  std::string_view names = {};  ///< "a|b"
  /// Taken only where none of `names` is found: a column "Strom" beside "I / mA" is none of ours.
  std::string_view otherwise = {};
  /// The first name found in the order of the list is taken; otherwise two matches are an error.
  bool in_order = false;
  /// The unit that the format is known to mean where its header states none; "" where the header
  /// must.
  std::string_view known_unit = {};
};

struct Layout {
  std::string_view name;
  std::string_view summary;
  /// Each entry is a set of alternatives, "a|b"; a header that holds one of each is of this format.
  /// An alternative matches a name with or without its unit.
  std::array<std::string_view, 6> signature = {};
  std::array<ColumnNames, kQuantityCount> columns = {};
  /// Names of a clock that runs through all steps when `columns` has none, and restarts with each
  /// step.
  ColumnNames step_clock = {};
  /// A column of dates: the time where no other column is, and the judge of a time column without a
  /// unit.
  ColumnNames date = {};
  DateOrder date_order = DateOrder::kYearFirst;
  /// For exports without a header: the header that belongs to them, and whether a first line is
  /// such a row.
  std::string_view implied_header = {};
  bool (*is_row)(std::span<const TextCell> cells) = nullptr;
  /// Headers of the levels above the rows, as signature entries, one set per level; rows are
  /// indented.
  std::span<const std::span<const std::string_view>> level_signatures = {};
  /// With a current column of this name, a voltage column without a unit may be in V or mV: the
  /// values decide.
  std::string_view millivolts_beside = {};
  /// Lines that start with # are comments.
  bool comments = false;
  /// The format defines the sign of its current, and it is not searched for.
  bool discharge_is_positive = false;
  /// So it does how long the current of a row holds; none: the option `hold` says it.
  std::optional<Hold> hold = {};

  [[nodiscard]] const ColumnNames& Of(Quantity quantity) const {
    return columns[static_cast<std::size_t>(quantity)];
  }
};

/// Every format is described in its file.
extern const Layout kArbin;
extern const Layout kBasytec;
extern const Layout kBatteryDataFormat;
extern const Layout kBetaflight;
extern const Layout kBiologic;
extern const Layout kBitrode;
extern const Layout kDigatron;
extern const Layout kMaccor;
extern const Layout kNeware;
extern const Layout kNovonix;
extern const Layout kPlainCsv;
extern const Layout kSimulatedFlight;

}  // namespace lipoid
