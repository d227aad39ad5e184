#pragma once

/// @file
/// Rows whose voltage, current or temperature cannot be: a reading that failed, alone between two that did not, or one
/// without a cell.
/// Tests: tests/identify/logs/spikes_test.cc.

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "identify/logs/record.h"

namespace lipoid {

/// Rows whose voltage leaves the range of all other rows by half that range and by 0.2 V at least,
/// while the rows beside them stay within it and the current does not change the other way, there and back; and runs of
/// at most five rows with less than a tenth of the usual voltage, whatever flows.
/// The first and the last row have a neighbour on one side only and are never among the former: a discharge
/// may well end on a cliff. Linear in the number of rows.
[[nodiscard]] std::vector<std::size_t> FindSpikes(const Record& record);

/// How many rows at the beginning and at the end are at rest at a voltage that no rest falls to at once, which a logger
/// reads before the cell is put in or after it was taken out: below the range of all other rows by half that range and
/// by 0.2 V at least, or, beside a load, below 0.6 of the least of them. However many they are.
struct RowsWithoutCell {
  std::size_t first = 0;
  std::size_t last = 0;
};
[[nodiscard]] RowsWithoutCell FindRowsWithoutCell(const Record& record);

/// Rows whose current leaves the range of all other rows by half of it, while the rows beside them stay
/// within it and the voltage moves by less than a quarter of what other steps of the current make it move
/// (where there are none, by less than 5 mV under five times the largest current). Never the first or the
/// last row; none where they are more than five or carry all the load, and none of a record without voltages.
[[nodiscard]] std::vector<std::size_t> FindCurrentSpikes(const Record& record);

/// Rows whose temperature is no reading of the cell: it jumps there by 8 K and at 0.5 K/s or more, which no cell does,
/// and back to within 3 K and what 0.05 K/s make of the time between; at either end of a record, rows before or behind
/// such a jump where they are at most five. None of ten rows or fewer. `no_way_back` is the row of a jump that does not
/// come back, after which the column cannot be told from one of a sensor that came off.
struct FailedTemperatures {
  std::vector<std::size_t> rows;
  std::optional<std::size_t> no_way_back;
};
[[nodiscard]] FailedTemperatures FindFailedTemperatures(std::span<const double> time_s,
                                                        std::span<const double> temperature_degC);

}  // namespace lipoid
