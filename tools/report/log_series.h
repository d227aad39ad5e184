#pragma once

/// @file
/// A log with what a cell predicts of it, as a series of a report. Tests:
/// tests/tools/report_test.cc.

#include <cstddef>
#include <string>

#include "identify/logs/record.h"
#include "model/battery/cell.h"
#include "model/battery/prediction.h"
#include "tools/report/report.h"

namespace lipoid {

/// Rows of all logs of a page together: with four columns of 4 to 8 bytes, in base64, it stays below
/// 2 MB.
inline constexpr std::size_t kRowsOfPage = 48000;

/// Kind "log", with time_s, current_A, voltage_V and predicted_V and, where the record has it,
/// temperature_degC; thinned to at most `most_rows`. The record is that of the pack that the cell's
/// series and parallel make.
[[nodiscard]] Series LogSeries(const Cell& cell,
                               const Record& record,
                               const std::string& name,
                               double initial_soc,
                               std::size_t most_rows,
                               const Surroundings& surroundings = {});

}  // namespace lipoid
