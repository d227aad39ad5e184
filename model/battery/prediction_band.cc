#include "model/battery/prediction_band.h"

#include <deque>

#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/stop.h"
#include "model/statistics/interval_95.h"

namespace lipoid {

PredictionBand PredictBand(std::span<const Cell> cells,
                           std::span<const double> initial_soc,
                           std::span<const double> time_s,
                           std::span<const double> current_A,
                           Hold hold,
                           const Surroundings& surroundings) {
  Require(!cells.empty() && initial_soc.size() == cells.size(), "cells, each with its start");
  Require(time_s.size() == current_A.size(), "as many times as currents");
  std::deque<RowPredictor> walks;
  for (std::size_t c = 0; c < cells.size(); ++c) walks.emplace_back(cells[c], hold, initial_soc[c]);
  PredictionBand band;
  band.voltage_low_V.resize(time_s.size());
  band.voltage_high_V.resize(time_s.size());
  // A few rows at a time, so that memory does not grow with the log.
  constexpr std::size_t kRowsAtOnce = 1024;
  std::vector<double> voltage_V(kRowsAtOnce * cells.size());
  for (std::size_t from = 0; from < time_s.size(); from += kRowsAtOnce) {
    const std::size_t rows = std::min(kRowsAtOnce, time_s.size() - from);
    Surroundings block = surroundings;
    if (!block.measured_degC.empty()) block.measured_degC = block.measured_degC.subspan(from, rows);
    ParallelFor(cells.size(), [&](std::size_t c) {
      StopIfAsked();
      walks[c].Rows(time_s.subspan(from, rows),
                    current_A.subspan(from, rows),
                    block,
                    [&](std::size_t k, const PredictedRow& row) {
                      voltage_V[k * cells.size() + c] = row.voltage_V;
                    });
    });
    ParallelFor(rows, [&](std::size_t k) {
      const auto [low_V, high_V] =
          Interval95(std::span(voltage_V).subspan(k * cells.size(), cells.size()));
      band.voltage_low_V[from + k] = low_V;
      band.voltage_high_V[from + k] = high_V;
    });
  }
  return band;
}

}  // namespace lipoid
