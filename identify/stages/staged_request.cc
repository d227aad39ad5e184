#include "identify/stages/staged_request.h"

#include "identify/stages/open_circuit_voltage_file.h"

namespace lipoid {

void StagedRequest::Resolve() {
  if (branches) options.pulses.branches = *branches;
  if (no_diffusion) options.pulses.diffusion = false;
  if (!open_circuit_voltage.given()) return;
  given.open_circuit_voltage_source = open_circuit_voltage.name();
  given.open_circuit_voltage = open_circuit_voltage.cell
                                   ? open_circuit_voltage.cell->open_circuit_voltage
                                   : ReadOpenCircuitVoltageFile(open_circuit_voltage.path);
}

}  // namespace lipoid
