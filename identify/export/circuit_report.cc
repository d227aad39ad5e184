#include "identify/export/circuit_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "identify/export/law_limits.h"

namespace lipoid {

std::optional<EquivalentCircuit> ReportCircuit(const ExportRequest& request, Exported& exported) {
  const Cell& cell = request.cell;
  const SingleCell one(request);
  FittedCircuit fitted = FitCircuit(one, request.branches);
  if (!Usable(fitted.projection, exported)) return std::nullopt;
  const EquivalentCircuit& circuit = fitted.circuit;
  // The law of one cell, the error of the pack.
  const auto error_of = [&](const EquivalentCircuit& law) {
    ExportError error = VoltageError(
        one.reference, one.mission, EquivalentCircuitVoltage(law, one.mission, one.drawn_Ah));
    error.rmse_V *= cell.series;
    error.max_error_V *= cell.series;
    for (double& law_V : error.law_V) law_V *= cell.series;
    return error;
  };
  exported.error = error_of(circuit);
  exported.naive = error_of(NaiveCircuit(cell, request.branches));
  exported.parameters = {{"capacity", circuit.capacity_Ah, "Ah"}};
  const auto add = [&](const std::string& name, const std::vector<double>& nodes) {
    for (std::size_t k = 0; k < nodes.size(); ++k)
      exported.parameters.push_back(
          {fmt::format("{}({:g})", name, circuit.soc[k]), nodes[k], "Ohm"});
  };
  add("R0", circuit.series_Ohm);
  for (std::size_t j = 0; j < circuit.branches.size(); ++j) {
    exported.parameters.push_back(
        {fmt::format("tau{}", j + 1), circuit.branches[j].time_constant_s, "s"});
    add(fmt::format("R{}", j + 1), circuit.branches[j].resistance_Ohm);
  }
  exported.cannot_hold = LeftOut(request, {.branches = request.branches, .resistance_table = true});
  const auto& soc = one.reference.soc;
  const double lowest =
      1.0 - *std::max_element(one.drawn_Ah.begin(), one.drawn_Ah.end()) / circuit.capacity_Ah;
  exported.notes = {
      "The numbers are those of one cell; multiply volts by the cells in series and divide currents "
      "by those in parallel.",
      fmt::format("The mission reaches a state of charge of {:.3f} by charge ({:.3f} of the cell): "
                  "the resistances below that are those of the last node that it saw.",
                  lowest,
                  *std::min_element(soc.begin(), soc.end()))};
  if (cell.open_circuit_voltage_assumed)
    exported.notes.emplace_back("The cell's v_oc is a typical curve, not a measured one.");
  AddBoundNotes(fitted.projection, exported);
  return circuit;
}

std::string NumberList(const std::vector<double>& values) {
  return fmt::format("{}", fmt::join(values, ", "));
}

}  // namespace lipoid
