#pragma once

/// @file
/// What a log says, after everything about its format is forgotten.

#include <cstddef>
#include <string>
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

/// Voltages over the cells in series, currents over those in parallel.
void DivideByPack(Record& record, int series, int parallel);

/// Charge that left between the first row and each row, in C, by the hold of the record.
[[nodiscard]] std::vector<double> DeliveredCharge(const Record& record);

}  // namespace lipoid
