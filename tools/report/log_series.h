#pragma once

/// @file
/// Logs with what cells predict of them, as series of a report. Tests:
/// tests/tools/report_page_test.cc.

#include <cstddef>
#include <memory>
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
  std::vector<double> soc;        ///< found by ThinnedBy()
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
/// where it has none.
[[nodiscard]] Series LogSeries(std::span<const PredictedColumn> cells,
                               const Record& record,
                               const std::string& name,
                               double initial_soc,
                               std::size_t most_rows,
                               const Surroundings& surroundings = {});

/// What a log is thinned by of one cell, for all rows: its error where the voltage was measured, else
/// its prediction. One column of a log of millions of rows is much to keep; what it was made of is
/// found again.
using ColumnOfPage = std::unique_ptr<double[]>;

/// `over_charge` is filled at its rows, by the way.
[[nodiscard]] ColumnOfPage ThinnedBy(const Cell& cell,
                                     const Record& record,
                                     double initial_soc,
                                     const Surroundings& surroundings = {},
                                     RowsOverCharge* over_charge = nullptr);

/// The same series of what ThinnedBy() found of each cell.
[[nodiscard]] Series LogSeries(std::span<const PredictedColumn> cells,
                               const Record& record,
                               const std::string& name,
                               std::size_t most_rows,
                               std::span<const ColumnOfPage> of_cell);

}  // namespace lipoid
