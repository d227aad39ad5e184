#include "model/battery/prediction.h"

#include "model/core/errors.h"

namespace lipoid {

Prediction Predict(const Cell& cell,
                   std::span<const double> time_s,
                   std::span<const double> current_A,
                   Hold hold,
                   double initial_soc) {
  Require(time_s.size() == current_A.size(),
          "as many times as currents",
          {{"times", static_cast<double>(time_s.size())},
           {"currents", static_cast<double>(current_A.size())}});
  const CellModel<double> model(cell.Parameters());
  RecordStepper<double> stepper(model, hold, model.Relaxed(initial_soc));
  Prediction prediction;
  prediction.voltage_V.resize(time_s.size());
  prediction.open_circuit_V.resize(time_s.size());
  prediction.soc.resize(time_s.size());
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    stepper.Row(time_s[k], current_A[k] / cell.parallel);
    const double soc = stepper.Soc();
    prediction.soc[k] = soc;
    prediction.open_circuit_V[k] = cell.series * cell.open_circuit_voltage(soc);
    prediction.voltage_V[k] = cell.series * stepper.Voltage();
    if (!cell.open_circuit_voltage.InRange(soc)) ++prediction.rows_outside_curve;
  }
  return prediction;
}

}  // namespace lipoid
