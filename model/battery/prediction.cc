#include "model/battery/prediction.h"

namespace lipoid {

Prediction Predict(const Cell& cell,
                   std::span<const double> time_s,
                   std::span<const double> current_A,
                   Hold hold,
                   double initial_soc) {
  Prediction prediction;
  prediction.voltage_V.resize(time_s.size());
  prediction.open_circuit_V.resize(time_s.size());
  prediction.soc.resize(time_s.size());
  const auto keep = [&](std::size_t k, double soc, double voltage_V) {
    prediction.soc[k] = soc;
    prediction.open_circuit_V[k] = cell.series * cell.open_circuit_voltage(soc);
    prediction.voltage_V[k] = voltage_V;
    if (!cell.open_circuit_voltage.InRange(soc)) ++prediction.rows_outside_curve;
  };
  PredictRows(cell, time_s, current_A, hold, initial_soc, keep);
  return prediction;
}

}  // namespace lipoid
