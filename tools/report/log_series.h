#pragma once

/// @file
/// Logs with what cells predict of them, as series of a report. Tests:
/// tests/tools/report_page_test.cc.

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "identify/logs/record.h"
#include "model/battery/cell.h"
#include "model/battery/prediction.h"
#include "tools/report/report.h"

namespace lipoid {

/// A cell whose prediction is a column of the series.
struct PredictedColumn {
  std::string name;  ///< "predicted_V"
  const Cell* cell = nullptr;
};

/// The state of charge, and the voltage that the first of the cells predicts, at some rows.
struct RowsOverCharge {
  std::vector<std::size_t> rows;  ///< increasing
  std::vector<double> soc;        ///< found by LogSeries()
  std::vector<double> predicted_V;
};

/// How many rows each of some logs may keep, so that the page of all of them stays below 2 MB: an
/// equal share each, and what short ones leave goes to the longer ones. `columns` counts those
/// beside time_s.
[[nodiscard]] std::vector<std::size_t> RowsOfPage(std::span<const std::size_t> rows,
                                                  std::size_t columns);

/// Kind "log", with time_s, current_A, voltage_V, a column for each cell and, where the record has
/// it, temperature_degC; thinned to at most `most_rows`, with the peaks of the errors kept. The
/// record is that of the pack that series and parallel of the cells make; no column of a voltage
/// where it has none. `over_charge` is filled at its rows, by the way.
[[nodiscard]] Series LogSeries(std::span<const PredictedColumn> cells,
                               const Record& record,
                               const std::string& name,
                               double initial_soc,
                               std::size_t most_rows,
                               const Surroundings& surroundings = {},
                               RowsOverCharge* over_charge = nullptr);

}  // namespace lipoid
