#include "model/battery/cell.h"

namespace lipoid {

CellParameters<double> Cell::Parameters() const {
  CellParameters<double> parameters;
  parameters.alpha_C = alpha_C();
  parameters.diffusion = diffusion.has_value();
  if (diffusion) {
    parameters.beta_per_sqrt_s = diffusion->beta_per_sqrt_s;
    parameters.terms = diffusion->terms;
    parameters.tail = diffusion->tail;
  }
  parameters.series_resistance_Ohm = series_resistance_Ohm;
  for (const Branch& branch : branches) {
    parameters.branches.push_back({branch.resistance_Ohm, branch.time_constant_s});
  }
  parameters.open_circuit_voltage = open_circuit_voltage;
  parameters.self_heating = self_heating;
  parameters.charge_transfer = charge_transfer;
  parameters.temperature = temperature;
  parameters.hysteresis = hysteresis;
  return parameters;
}

Cell Cell::AsOne() const {
  Cell one = *this;
  one.series = one.parallel = 1;
  return one;
}

}  // namespace lipoid
