#include "model/battery/prediction_band.h"

#include <tbb/parallel_for.h>

#include <memory>

#include "model/core/errors.h"
#include "model/core/stop.h"
#include "model/statistics/interval_95.h"

namespace lipoid {
namespace {

// One cell on its way along the rows.
struct Walk {
  Walk(const Cell& cell, double initial_soc, Hold hold, const Surroundings& surroundings)
      : series(cell.series),
        parallel(cell.parallel),
        model(cell.Parameters()),
        stepper(model, hold, StartAmong(model, initial_soc, surroundings)) {}

  double series, parallel;
  CellModel<double> model;
  RecordStepper<double> stepper;
};

}  // namespace

PredictionBand PredictBand(std::span<const Cell> cells,
                           std::span<const double> initial_soc,
                           std::span<const double> time_s,
                           std::span<const double> current_A,
                           Hold hold,
                           const Surroundings& surroundings) {
  Require(!cells.empty() && initial_soc.size() == cells.size(), "cells, each with its start");
  Require(time_s.size() == current_A.size(), "as many times as currents");
  std::vector<std::unique_ptr<Walk>> walks;
  for (std::size_t c = 0; c < cells.size(); ++c)
    walks.push_back(std::make_unique<Walk>(cells[c], initial_soc[c], hold, surroundings));
  PredictionBand band;
  band.voltage_low_V.resize(time_s.size());
  band.voltage_high_V.resize(time_s.size());
  // A few rows at a time, so that memory does not grow with the log.
  constexpr std::size_t kRows = 1024;
  std::vector<double> voltage_V(kRows * cells.size());
  for (std::size_t from = 0; from < time_s.size(); from += kRows) {
    const std::size_t rows = std::min(kRows, time_s.size() - from);
    tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t c) {
      StopIfAsked();
      Walk& walk = *walks[c];
      for (std::size_t k = 0; k < rows; ++k) {
        walk.stepper.Row(time_s[from + k], current_A[from + k] / walk.parallel);
        if (!surroundings.measured_degC.empty()) {
          walk.stepper.SetTemperature(surroundings.measured_degC[from + k] + kZeroCelsius_K);
        }
        voltage_V[k * cells.size() + c] = walk.series * walk.stepper.Voltage();
      }
    });
    tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t k) {
      const auto [low_V, high_V] =
          Interval95(std::span(voltage_V).subspan(k * cells.size(), cells.size()));
      band.voltage_low_V[from + k] = low_V;
      band.voltage_high_V[from + k] = high_V;
    });
  }
  return band;
}

}  // namespace lipoid
