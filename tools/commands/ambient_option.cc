#include "tools/commands/ambient_option.h"

#include "model/battery/typical_temperature.h"

namespace lipoid {

Cell KnowingTemperature(cli::CommandLine& line,
                        const Cell& cell,
                        const std::string& cell_name,
                        double size_factor) {
  if (cell.temperature) return cell;
  Cell knowing = WithTypicalTemperature(cell, size_factor);
  const Cell::Temperature& term = *knowing.temperature;
  line.Message(
      "{} knows no temperature: typical values about {:.3g} degC{} are assumed, {:g} kJ/mol for its series "
      "resistance, {:g} kJ/mol for its diffusion, a heat capacity of {:.3g} J/K and {:.3g} K/W "
      "to the air for each cell{}",
      cell_name,
      term.reference_K - kZeroCelsius_K,
      cell.reference_degC ? ", where its logs were," : "",
      1e-3 * term.series_J_per_mol,
      1e-3 * term.diffusion_J_per_mol,
      term.heat->heat_capacity_J_per_K * size_factor,
      term.heat->thermal_resistance_K_per_W / size_factor,
      cell.self_heating ? "; they take the place of its self-heating (rho_h, tau_h)" : "");
  return knowing;
}

}  // namespace lipoid
