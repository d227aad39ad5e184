#pragma once

/// @file
/// What a log says, after everything about its format is forgotten.

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "identify/logs/column.h"
#include "model/battery/record_stepper.h"

namespace lipoid {

/// Columns of equal length, SI units, discharge current positive, time strictly increasing. All
/// values are finite. Rows are those of the whole pack until DivideByPack() made them one cell's.
struct Record {
  std::string file;  ///< where it came from, for messages
  Column time_s;
  Column current_A;
  Column voltage_V;         ///< empty where only a current was wanted
  Column temperature_degC;  ///< empty where the log has none
  Hold hold = Hold::kBackward;

  [[nodiscard]] std::size_t size() const { return time_s.size(); }
};

/// For what is done with every column of a record.
inline constexpr Column Record::*kRecordColumns[] = {
    &Record::time_s, &Record::current_A, &Record::voltage_V, &Record::temperature_degC};

/// Leaves rows, which rise, out of a column that has any.
template <class Values>
void DropRows(Values& column, const std::vector<std::size_t>& rows) {
  if (column.empty() || rows.empty()) return;
  std::vector<typename Values::value_type> kept;
  kept.reserve(column.size() - rows.size());
  auto next = rows.begin();
  for (std::size_t k = 0; k < column.size(); ++k) {
    if (next != rows.end() && *next == k) {
      ++next;
    } else {
      kept.push_back(std::as_const(column)[k]);
    }
  }
  column = std::move(kept);
}
inline void DropRows(Record& record, const std::vector<std::size_t>& rows) {
  for (const auto column : kRecordColumns) DropRows(record.*column, rows);
}

/// Whether two records hold the same rows, as a log and its copy under another name do.
[[nodiscard]] bool HoldTheSameRows(const Record& one, const Record& other);

/// Voltages over the cells in series, currents over those in parallel.
void DivideByPack(Record& record, int series, int parallel);

/// Charge that left between the first row and each row, in C, by the hold of the record.
[[nodiscard]] std::vector<double> DeliveredCharge(const Record& record);

}  // namespace lipoid
