#include "model/battery/prediction.h"

namespace lipoid {

CellModel<double>::State StartAmong(const CellModel<double>& model,
                                    double initial_soc,
                                    const Surroundings& surroundings) {
  auto state = model.Relaxed(initial_soc);
  const auto& measured_degC = surroundings.measured_degC;
  if (surroundings.ambient_degC) state.temperature_K = *surroundings.ambient_degC + kZeroCelsius_K;
  if (measured_degC.empty()) {
    state.ambient_K = state.temperature_K;
  } else {
    state.temperature_K = measured_degC.front() + kZeroCelsius_K;
  }
  if (surroundings.initial_degC) state.temperature_K = *surroundings.initial_degC + kZeroCelsius_K;
  return state;
}

Prediction Predict(const Cell& cell,
                   std::span<const double> time_s,
                   std::span<const double> current_A,
                   Hold hold,
                   double initial_soc,
                   const Surroundings& surroundings) {
  Prediction prediction;
  prediction.voltage_V.resize(time_s.size());
  prediction.open_circuit_V.resize(time_s.size());
  prediction.soc.resize(time_s.size());
  const auto keep = [&](std::size_t k, const PredictedRow& row) {
    prediction.soc[k] = row.soc;
    prediction.open_circuit_V[k] = cell.series * row.stepper.OpenCircuit();
    prediction.voltage_V[k] = row.voltage_V;
    if (cell.temperature) {
      prediction.temperature_degC.push_back(row.stepper.state().temperature_K - kZeroCelsius_K);
    }
    if (!cell.open_circuit_voltage.InRange(row.soc)) ++prediction.rows_outside_curve;
  };
  PredictRows(cell, time_s, current_A, hold, initial_soc, surroundings, keep);
  return prediction;
}

}  // namespace lipoid
