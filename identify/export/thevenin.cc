#include <fmt/format.h>

#include "identify/export/circuit_fit.h"
#include "identify/export/fitted_targets.h"
#include "model/export/cell_numbers.h"
#include "model/export/provenance.h"

namespace lipoid {

Exported ExportThevenin(const ExportRequest& request) {
  Exported exported;
  const auto circuit = ReportCircuit(request, exported);
  if (!circuit) return exported;
  exported.notes.emplace_back(
      "The file holds functions that the package evaluates: load it only from whom you trust, as "
      "any program.");

  std::string yaml = Commented(ProvenanceLines(request, exported), "# ");
  const auto number = [&](std::string_view key, double value) {
    yaml += fmt::format("{}: {}\n", key, CNumber(value));  // without a point it would be an integer
  };
  const auto function = [&](std::string_view key,
                            std::string_view arguments,
                            const std::vector<double>& soc,
                            const std::vector<double>& values) {
    yaml += fmt::format("{}: !eval |\n  lambda {}: np.interp(soc, [{}],\n    [{}])\n",
                        key,
                        arguments,
                        NumberList(soc),
                        NumberList(values));
  };
  yaml += fmt::format("num_RC_pairs: {}\n", circuit->branches.size());
  number("soc0", 1.0);
  number("capacity", circuit->capacity_Ah);
  number("ce", 1.0);
  number("gamma", 0.0);
  // Isothermal: mass and heat play no part, but every key must be there.
  number("mass", 0.05);
  yaml += "isothermal: true\n";
  number("Cp", 1000.0);
  number("T_inf", 298.15);
  number("h_therm", 10.0);
  number("A_therm", 0.01);
  function("ocv", "soc", circuit->open_circuit.soc, circuit->open_circuit.voltage_V);
  yaml += "M_hyst: !eval |\n  lambda soc: 0.0*soc\n";
  function("R0", "soc, T_cell", circuit->soc, circuit->series_Ohm);
  for (std::size_t j = 0; j < circuit->branches.size(); ++j) {
    const auto& branch = circuit->branches[j];
    function(fmt::format("R{}", j + 1), "soc, T_cell", circuit->soc, branch.resistance_Ohm);
    // One time constant: the capacitance follows the resistance between the nodes too.
    yaml +=
        fmt::format("C{}: !eval |\n  lambda soc, T_cell: {} / np.interp(soc, [{}],\n    [{}])\n",
                    j + 1,
                    branch.time_constant_s,
                    NumberList(circuit->soc),
                    NumberList(branch.resistance_Ohm));
  }
  exported.files = {{".yaml", std::move(yaml)}};
  return exported;
}

}  // namespace lipoid
