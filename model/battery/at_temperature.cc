#include "model/battery/at_temperature.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace lipoid {
namespace {

// f(A) + above_K dv_oc/dT(A). Both are straight between the nodes of either, where f is a table; a
// curve of another kind is taken at fine steps.
OpenCircuitVoltage Shifted(const OpenCircuitVoltage& curve,
                           const EntropySlope<double>& entropy,
                           double above_K) {
  constexpr int kSteps = 400;
  std::vector<double> nodes;
  for (int k = 0; k <= kSteps; ++k)
    nodes.push_back(curve.soc_lo() + (curve.soc_hi() - curve.soc_lo()) * k / kSteps);
  if (curve.method() == OcvMethod::kLinear) nodes = curve.soc();
  for (const double a : entropy.soc) {
    if (a > curve.soc_lo() && a < curve.soc_hi()) nodes.push_back(a);
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  std::vector<double> voltage_V;
  for (const double a : nodes) voltage_V.push_back(curve(a) + above_K * entropy(a));
  return OpenCircuitVoltage::Linear(std::move(nodes), std::move(voltage_V));
}

}  // namespace

Cell AtOneTemperature(Cell cell, double temperature_degC) {
  if (!cell.temperature) return cell;
  const Cell::Temperature term = *std::exchange(cell.temperature, std::nullopt);
  const double temperature_K = temperature_degC + kZeroCelsius_K;
  const auto factor = [&](double energy_J_per_mol) {
    return term.Factor(energy_J_per_mol, temperature_K);
  };
  cell.series_resistance_Ohm.Scale(factor(term.series_J_per_mol));
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    Cell::Branch& branch = cell.branches[j];
    const double f = factor(term.branches_J_per_mol[j]);
    branch.resistance_Ohm.Scale(f);
    if (branch.capacitance_F) *branch.capacitance_F /= f;
  }
  if (cell.diffusion) {
    double& beta = cell.diffusion->beta_per_sqrt_s;
    beta = std::min(beta / std::sqrt(factor(term.diffusion_J_per_mol)), 1.0);
  }
  if (cell.charge_transfer) {
    // (T/T_ref) r i_0 asinh(f i/i_0), with i_0/f for i_0.
    const double f = factor(term.charge_transfer_J_per_mol);
    cell.charge_transfer->current_A /= f;
    cell.charge_transfer->resistance_Ohm.Scale(f * temperature_K / term.reference_K);
  }
  if (term.entropy) {
    cell.open_circuit_voltage =
        Shifted(cell.open_circuit_voltage, *term.entropy, temperature_K - term.reference_K);
  }
  return cell;
}

}  // namespace lipoid
