#include "model/battery/charge_axis.h"

#include <cmath>
#include <utility>
#include <vector>

namespace lipoid {
namespace {

OpenCircuitVoltage Moved(const OpenCircuitVoltage& curve, double start_soc, double ratio) {
  const auto move = [&](double soc) { return start_soc - (start_soc - soc) * ratio; };
  const auto nodes = [&] {
    std::vector<double> soc = curve.soc();
    for (double& a : soc) a = move(a);
    return soc;
  };
  const double lo = move(curve.soc_lo());
  const double hi = move(curve.soc_hi());
  if (curve.method() == OcvMethod::kLinear)
    return OpenCircuitVoltage::Linear(nodes(), curve.voltage_V());
  if (curve.method() == OcvMethod::kMonotoneCubic)
    return OpenCircuitVoltage::MonotoneCubic(nodes(), curve.voltage_V());
  if (curve.method() == OcvMethod::kPolynomial)
    return OpenCircuitVoltage::Polynomial(lo, hi, curve.coefficients_V());
  // A = start (1 - 1/ratio) + A'/ratio: another frequency, and harmonics that begin elsewhere.
  auto cosine_V = curve.coefficients_V();
  auto sine_V = curve.sine_V();
  for (std::size_t k = 1; k < cosine_V.size(); ++k) {
    const double phase =
        static_cast<double>(k) * curve.frequency_rad() * start_soc * (1.0 - 1.0 / ratio);
    const double a = cosine_V[k];
    const double b = sine_V[k - 1];
    cosine_V[k] = a * std::cos(phase) + b * std::sin(phase);
    sine_V[k - 1] = b * std::cos(phase) - a * std::sin(phase);
  }
  return OpenCircuitVoltage::Fourier(
      lo, hi, curve.frequency_rad() / ratio, std::move(cosine_V), std::move(sine_V));
}

}  // namespace

void MoveChargeAxis(Cell& cell, double start_soc, double ratio) {
  if (ratio == 1.0) return;
  const auto move = [&](std::vector<double>& soc) {
    for (double& a : soc) a = start_soc - (start_soc - a) * ratio;
  };
  move(cell.series_resistance_Ohm.soc);
  for (auto& branch : cell.branches) move(branch.resistance_Ohm.soc);
  if (cell.charge_transfer) move(cell.charge_transfer->resistance_Ohm.soc);
  if (cell.temperature && cell.temperature->entropy) move(cell.temperature->entropy->soc);
  if (cell.hysteresis) {
    move(cell.hysteresis->soc);
    cell.hysteresis->folds /= ratio;
  }
  cell.open_circuit_voltage = Moved(cell.open_circuit_voltage, start_soc, ratio);
}

}  // namespace lipoid
