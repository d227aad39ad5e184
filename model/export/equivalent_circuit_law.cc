#include "model/export/equivalent_circuit_law.h"

#include <algorithm>
#include <cmath>

#include "model/battery/soc_table.h"

namespace lipoid {

std::vector<double> EquivalentCircuitVoltage(const EquivalentCircuit& circuit,
                                             const ExportMission& mission,
                                             const std::vector<double>& drawn_Ah) {
  std::vector<double> branch_V(circuit.branches.size(), 0.0);
  std::vector<double> volts(mission.time_s.size());
  double soc = 1.0;
  for (std::size_t k = 0; k < volts.size(); ++k) {
    const double before = soc;
    soc = 1.0 - drawn_Ah[k] / circuit.capacity_Ah;
    if (k > 0) {
      const double flow_A = mission.FlowBefore_A(k);
      const double steps = std::max(1.0, std::ceil(std::abs(soc - before) / kLargestSocStep));
      const double dt_s = (mission.time_s[k] - mission.time_s[k - 1]) / steps;
      for (std::size_t j = 0; j < branch_V.size(); ++j) {
        const auto& branch = circuit.branches[j];
        const double share = -std::expm1(-dt_s / branch.time_constant_s);
        for (double n = 0.0; n < steps; n += 1.0) {
          const double middle = before + (soc - before) * (n + 0.5) / steps;
          const double goal_V = OverSoc(circuit.soc, branch.resistance_Ohm, middle) * flow_A;
          branch_V[j] += share * (goal_V - branch_V[j]);
        }
      }
    }
    volts[k] = OverSoc(circuit.open_circuit.soc, circuit.open_circuit.voltage_V, soc) -
               OverSoc(circuit.soc, circuit.series_Ohm, soc) * mission.current_A[k];
    for (const double drop_V : branch_V) volts[k] -= drop_V;
  }
  return volts;
}

}  // namespace lipoid
