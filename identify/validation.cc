#include "identify/validation.h"

#include <fmt/format.h>

#include <cmath>

#include "model/core/errors.h"

namespace lipoid {

Validation Validate(const Cell& cell, const Record& record, double initial_soc) {
  constexpr double kLowSoc = 0.1;
  Validation result;
  result.prediction = Predict(cell, record.time_s, record.current_A, record.hold, initial_soc);
  ErrorAccumulator all;
  ErrorAccumulator above;
  for (std::size_t k = 0; k < record.size(); ++k) {
    const double predicted_V = result.prediction.voltage_V[k];
    all.Add(record.voltage_V[k], predicted_V);
    if (result.prediction.soc[k] > kLowSoc) above.Add(record.voltage_V[k], predicted_V);
  }
  result.all = all.Result();
  result.above_10_soc = above.Result();
  return result;
}

double SocAtRestVoltage(const Cell& cell, double voltage_V) {
  const double of_one_V = voltage_V / cell.series;
  const double soc = cell.open_circuit_voltage.SocAtVoltage(of_one_V);
  // At an end of the curve SocAtVoltage() gives the end: a voltage beyond it is none of this
  // cell's.
  constexpr double kTolerance_V = 1e-3;
  const double found_V = cell.open_circuit_voltage(soc);
  if (!(std::abs(found_V - of_one_V) <= kTolerance_V)) {
    throw OptionError(
        fmt::format("initial voltage: expected one that v_oc(A) of the cell has, {:.4g} .. {:.4g} "
                    "V, found {} V",
                    cell.series * cell.open_circuit_voltage(cell.open_circuit_voltage.soc_lo()),
                    cell.series * cell.open_circuit_voltage(cell.open_circuit_voltage.soc_hi()),
                    voltage_V));
  }
  return soc;
}

}  // namespace lipoid
