#include "tools/commands/start_options.h"

#include "identify/validation.h"
#include "model/battery/ranges.h"
#include "model/core/errors.h"

namespace lipoid {

void StartOptions::AddTo(cli::CommandLine& line) {
  line.Option("initial-soc",
              initial_soc,
              kInitialSocs,
              "state of charge of the first row; 1 is full, the default");
  line.Option(
      "initial-voltage-V",
      initial_voltage_V,
      Range{0.0, 1e5},
      "voltage in V at which the pack rested before the first row, instead of --initial-soc");
}

double StartOptions::Soc(const Cell& cell) const {
  if (initial_soc && initial_voltage_V) {
    throw OptionError("options --initial-soc and --initial-voltage-V: give one of them");
  }
  if (initial_voltage_V) return SocAtRestVoltage(cell, *initial_voltage_V);
  return initial_soc.value_or(1.0);
}

double StartOptions::SocOfDrawn(const Cell& cell) const {
  return initial_voltage_V
             ? cell.open_circuit_voltage.SocAtVoltage(*initial_voltage_V / cell.series)
             : initial_soc.value_or(1.0);
}

}  // namespace lipoid
