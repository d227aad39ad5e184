#include "model/battery/typical_temperature.h"

#include <fmt/format.h>

#include <cmath>

#include "model/core/errors.h"

namespace lipoid {

HeatBalance<double> TypicalHeat(double capacity_Ah, double size_factor) {
  constexpr double kNominal_V = 3.7;
  constexpr double kSpecificEnergy_Wh_per_kg = 150.0;
  constexpr double kSpecificHeat_J_per_kg_K = 1000.0;
  constexpr double kDensity_kg_per_m3 = 2000.0;
  constexpr double kSurface = 9.0;  // over the two-thirds power of the volume
  constexpr double kTransfer_W_per_m2_K = 15.0;
  const double mass_kg = size_factor * capacity_Ah * kNominal_V / kSpecificEnergy_Wh_per_kg;
  const double surface_m2 = kSurface * std::pow(mass_kg / kDensity_kg_per_m3, 2.0 / 3.0);
  return {.heat_capacity_J_per_K = mass_kg * kSpecificHeat_J_per_kg_K / size_factor,
          .thermal_resistance_K_per_W = size_factor / (kTransfer_W_per_m2_K * surface_m2)};
}

Cell WithTypicalTemperature(Cell cell, double size_factor) {
  Require(!cell.temperature, "a cell that knows no temperature yet");
  constexpr double kSeries_J_per_mol = 13e3;
  constexpr double kWithTransfer_J_per_mol = 20e3;
  constexpr double kBranches_J_per_mol = 40e3;
  constexpr double kDiffusion_J_per_mol = 40e3;
  constexpr double kChargeTransfer_J_per_mol = 65e3;
  Cell::Temperature& term = cell.temperature.emplace();
  if (cell.reference_degC) term.reference_K = *cell.reference_degC + kZeroCelsius_K;
  cell.reference_degC.reset();
  // Without a charge transfer of its own the drop of it is in the series resistance.
  term.series_J_per_mol = cell.charge_transfer ? kSeries_J_per_mol : kWithTransfer_J_per_mol;
  term.branches_J_per_mol.assign(cell.branches.size(), kBranches_J_per_mol);
  term.diffusion_J_per_mol = kDiffusion_J_per_mol;
  term.charge_transfer_J_per_mol = kChargeTransfer_J_per_mol;
  term.heat = TypicalHeat(cell.capacity_Ah, size_factor);
  cell.temperature_assumed = true;
  cell.temperature_seen.reset();  // nobody has seen these values anywhere
  cell.self_heating.reset();
  return cell;
}

std::string TypicalTemperatureText(const Cell& cell, double size_factor) {
  if (cell.temperature) return "";
  const Cell knowing = WithTypicalTemperature(cell, size_factor);
  const Cell::Temperature& term = *knowing.temperature;
  return fmt::format(
      "knows no temperature: typical values about {:.3g} degC{} are assumed, {:g} kJ/mol for its series "
      "resistance, {:g} kJ/mol for its diffusion, a heat capacity of {:.3g} J/K and {:.3g} K/W "
      "to the air for each cell{}",
      term.reference_K - kZeroCelsius_K,
      cell.reference_degC ? ", where its logs were," : "",
      1e-3 * term.series_J_per_mol,
      1e-3 * term.diffusion_J_per_mol,
      term.heat->heat_capacity_J_per_K * size_factor,
      term.heat->thermal_resistance_K_per_W / size_factor,
      cell.self_heating ? "; they take the place of its self-heating (rho_h, tau_h)" : "");
}

}  // namespace lipoid
