#include "identify/health/reference_cell.h"

#include <cmath>
#include <string_view>
#include <utility>
#include <vector>

#include "model/battery/typical_temperature.h"

namespace lipoid {
namespace {

void Scale(Resistance<double>& resistance, double factor) {
  for (double& value_Ohm : resistance.resistance_Ohm) value_Ohm *= factor;
}

// The thermal resistance goes with the surface.
double OfSurface(double factor) { return std::pow(factor, -2.0 / 3.0); }

// How a parameter of that name goes with the capacity.
double FactorOf(std::string_view name, double factor) {
  if (name.starts_with("r_")) return 1.0 / factor;
  if (name.starts_with("c_") || name == "i_0" || name == "alpha") return factor;
  if (name == "rho_h") return 1.0 / (factor * factor * factor);
  if (name == "C_th") return factor;
  if (name == "R_th") return OfSurface(factor);
  return 1.0;
}

// As many cells in parallel, as one.
void Enlarge(Cell& cell, double factor) {
  cell.capacity_Ah *= factor;
  if (cell.diffusion) cell.diffusion->alpha_C *= factor;
  Scale(cell.series_resistance_Ohm, 1.0 / factor);
  for (Cell::Branch& branch : cell.branches) {
    Scale(branch.resistance_Ohm, 1.0 / factor);
    branch.capacitance_F.reset();  // the time constant stays
  }
  if (cell.self_heating) cell.self_heating->resistance_drop_Ohm_per_A2 /= factor * factor * factor;
  if (cell.charge_transfer) {
    cell.charge_transfer->current_A *= factor;
    Scale(cell.charge_transfer->resistance_Ohm, 1.0 / factor);
  }
  if (cell.uncertainty) {
    Cell::Uncertainty& of = *cell.uncertainty;
    for (std::size_t a = 0; a < of.parameters.size(); ++a) {
      for (std::size_t b = 0; b < of.parameters.size(); ++b) {
        of.covariance[a][b] *=
            FactorOf(of.parameters[a], factor) * FactorOf(of.parameters[b], factor);
      }
    }
  }
  if (cell.temperature && cell.temperature->heat) {
    cell.temperature->heat->heat_capacity_J_per_K *= factor;
    cell.temperature->heat->thermal_resistance_K_per_W *= OfSurface(factor);
  }
}

// The activation energy of diffusion that is taken where none was identified is one of 10 to 70 kJ/mol that cells have
// (docs/joint.md): how fast diffusion becomes in a pack that warms decides what a flight takes for charge.
void DoubtDiffusionEnergy(Cell& cell) {
  if (!cell.diffusion) return;
  constexpr double kSpread_J_per_mol = 20e3;
  constexpr double kNormal = 1e6;  // degrees of freedom
  if (!cell.uncertainty)
    cell.uncertainty = {.parameters = {}, .covariance = {}, .degrees_of_freedom = kNormal};
  Cell::Uncertainty& of = *cell.uncertainty;
  for (std::vector<double>& row : of.covariance) row.push_back(0.0);
  of.parameters.emplace_back("E_d");
  of.covariance.emplace_back(of.parameters.size(), 0.0).back() =
      kSpread_J_per_mol * kSpread_J_per_mol;
}

}  // namespace

ReferenceCell MakeReference(const Cell& cell, int parallel, std::optional<double> capacity_Ah) {
  ReferenceCell reference{
      .cell = cell.AsOne(), .typical = cell.open_circuit_voltage_assumed, .spread = {}};
  Cell& one = reference.cell;
  const double now_Ah = one.alpha_C() / 3600.0;
  Enlarge(one, capacity_Ah ? *capacity_Ah / now_Ah : static_cast<double>(parallel));
  // A cell of which only the series resistance is known still relaxes when its load goes.
  constexpr double kShareOfSeries = 0.3;
  constexpr double kTimeConstant_s = 20.0;
  double branches_Ohm = 0.0;
  for (const Cell::Branch& branch : one.branches) branches_Ohm += branch.resistance_Ohm(0.5);
  const double series_Ohm = one.series_resistance_Ohm(0.5);
  if (branches_Ohm < 0.02 * series_Ohm) {
    one.branches = {{.resistance_Ohm = kShareOfSeries * series_Ohm,
                     .time_constant_s = kTimeConstant_s,
                     .capacitance_F = {}}};
    if (one.temperature)
      one.temperature->branches_J_per_mol.assign(1, one.temperature->series_J_per_mol);
    reference.spread.log_branches = 1.5;
    reference.spread.log_time_constants = 1.0;
  }
  // Loads of a flight warm a pack, and a warm pack has less resistance.
  if (!one.temperature) {
    one.capacity_Ah = one.alpha_C() / 3600.0;
    one = WithTypicalTemperature(std::move(one));
    DoubtDiffusionEnergy(one);
  }
  if (reference.typical) {
    reference.spread.log_series = 1.5;
    reference.spread.log_branches = 1.5;
    reference.spread.log_beta = 0.7;
    reference.spread.log_time_constants = 1.0;
    reference.spread.curve_V = 0.03;
    reference.spread.kinks_V = 0.01;
  }
  return reference;
}

ReferenceCell SameCell(const Cell& cell, bool temperature_known) {
  // Ten degrees more or less, at 20 kJ/mol.
  constexpr double kUnknownTemperature = 0.3;
  constexpr double kKnownTemperature = 0.05;
  const double resistances = temperature_known ? kKnownTemperature : kUnknownTemperature;
  ReferenceCell reference{.cell = cell.AsOne(),
                          .typical = cell.open_circuit_voltage_assumed,
                          .spread = {.log_capacity = kHeldSpread,
                                     .log_series = resistances,
                                     .log_branches = resistances,
                                     .log_beta = kHeldSpread,
                                     .log_time_constants = resistances,  // tau_j = r_j c_j
                                     .curve_V = 0.0}};
  Cell& one = reference.cell;
  if (!one.temperature) {
    one.capacity_Ah = one.alpha_C() / 3600.0;
    one = WithTypicalTemperature(std::move(one));
  }
  one.self_heating.reset();  // one mechanism for one thing
  return reference;
}

}  // namespace lipoid
