#include <fmt/format.h>

#include <algorithm>

#include "identify/export/circuit_fit.h"
#include "identify/export/fitted_targets.h"
#include "model/battery/soc_table.h"
#include "model/export/provenance.h"

namespace lipoid {

Exported ExportSimscape(const ExportRequest& request) {
  Exported exported;
  const auto circuit = ReportCircuit(request, exported);
  if (!circuit) return exported;
  exported.notes.emplace_back(
      "The names of the fields are those of the blocks' documentation, which names them as "
      "parameters of scripts; compare them with your release before you set them by name. Set the "
      "blocks to extrapolate linearly.");
  exported.notes.emplace_back(
      "The blocks interpolate all tables over one vector of the state of charge, so it has the nodes "
      "of all of them.");

  // One vector of nodes: those of v_oc within the reach of the mission's tables, and theirs.
  std::vector<double> soc = circuit->soc;
  for (const double node : circuit->open_circuit.soc) {
    if (node >= 0.0 && node <= 1.0) soc.push_back(node);
  }
  std::sort(soc.begin(), soc.end());
  soc.erase(std::unique(soc.begin(), soc.end()), soc.end());
  const auto over_all = [&](const std::vector<double>& nodes, const std::vector<double>& values) {
    std::vector<double> list;
    for (const double at : soc) list.push_back(OverSoc(nodes, values, at));
    return list;
  };
  std::string script = Commented(ProvenanceLines(request, exported), "% ");
  script += fmt::format("{} = struct();\n", request.name);
  const auto vector =
      [&](std::string_view field, std::string_view what, const std::vector<double>& v) {
        script += fmt::format("{}.{} = [{}];  % {}\n", request.name, field, NumberList(v), what);
      };
  vector("SOC_vec", "state of charge, a fraction", soc);
  vector("V0_vec",
         "open-circuit voltage, V",
         over_all(circuit->open_circuit.soc, circuit->open_circuit.voltage_V));
  vector("R0_vec", "terminal resistance, Ohm", over_all(circuit->soc, circuit->series_Ohm));
  constexpr std::string_view kOrdinal[] = {"first", "second"};
  for (std::size_t j = 0; j < circuit->branches.size(); ++j) {
    const auto& branch = circuit->branches[j];
    vector(fmt::format("R{}_vec", j + 1),
           fmt::format("{} polarization resistance, Ohm", kOrdinal[j]),
           over_all(circuit->soc, branch.resistance_Ohm));
    vector(fmt::format("tau{}_vec", j + 1),
           fmt::format("{} time constant, s", kOrdinal[j]),
           std::vector<double>(soc.size(), branch.time_constant_s));
  }
  script += fmt::format("{}.AH = {};  % cell capacity, A*hr\n", request.name, circuit->capacity_Ah);
  script += fmt::format(
      "{}.Ns = {};  % cells in series of the pack\n", request.name, request.cell.series);
  script += fmt::format(
      "{}.Np = {};  % cells in parallel of the pack\n", request.name, request.cell.parallel);
  exported.files = {{".m", std::move(script)}};
  return exported;
}

}  // namespace lipoid
