#include "identify/studies/pulse_study.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <nlohmann/json.hpp>

#include "identify/fit/cell_of_solution.h"
#include "model/battery/prediction.h"

namespace lipoid {
namespace {

StagedResult StagesBefore(const StudyInput& input) {
  StagedOptions options = input.options;
  options.pulses.branches = 0;
  StagedGiven given = input.given;
  given.parameters = {};  // they may name branches
  return IdentifyStaged(input.campaign, input.logs, options, given);
}

}  // namespace

PulseStudy::PulseStudy(const StudyInput& input) : input_(input), before_(StagesBefore(input)) {}

VoltageSweep PulseStudy::Sweep(int terms, bool tail) const {
  std::vector<SweepLog> logs;
  for (const LoadedLog& log : input_.logs) {
    if (log.entry.kind != before_.fitted_kind) continue;
    logs.push_back({&log.log.record, log.entry.initial_soc, log.entry.weight});
  }
  return VoltageSweep({.alpha_C = before_.alpha_C,
                       .diffusion = diffusion(),
                       .terms = terms,
                       .tail = tail,
                       .open_circuit_voltage = before_.cell.open_circuit_voltage},
                      std::move(logs));
}

PulseFitResult PulseStudy::Fit(const VoltageSweep& sweep,
                               int branches,
                               const SweepParameters* previous) const {
  PulseFitOptions options = input_.options.pulses;
  options.branches = branches;
  const PulseFitStart start{.beta_per_sqrt_s = before_.pulses.parameters.beta_per_sqrt_s,
                            .data = before_.start,
                            .previous = previous};
  return FitPulses(sweep, start, options, input_.options.solver, input_.given.parameters);
}

std::vector<std::vector<double>> PulseStudy::Residuals(const VoltageSweep& sweep,
                                                       const SweepParameters& p) const {
  Cell cell = before_.cell.AsOne();  // the records are those of one cell
  if (cell.diffusion) {
    cell.diffusion->terms = sweep.setup().terms;
    cell.diffusion->tail = sweep.setup().tail;
  }
  PutInto(cell, SolutionOf(p), 1.0);
  std::vector<std::vector<double>> residuals;
  for (const SweepLog& log : sweep.logs()) {
    const Record& record = *log.record;
    auto residual_V =
        Predict(cell, record.time_s, record.current_A, record.hold, log.initial_soc).voltage_V;
    for (std::size_t k = 0; k < residual_V.size(); ++k)
      residual_V[k] = record.voltage_V[k] - residual_V[k];
    residuals.push_back(std::move(residual_V));
  }
  return residuals;
}

int PulseStudy::FreeParameters(const PulseFitResult& fit) const {
  const auto branches = static_cast<int>(fit.parameters.time_constant_s.size());
  return (diffusion() ? 2 : 1) + 2 * branches - static_cast<int>(fit.fixed.size());
}

Json PulseStudy::Parameters(const SweepParameters& p) const {
  Json json = Json::object();
  if (diffusion()) json["beta"] = p.beta_per_sqrt_s;
  json["r_s"] = p.series_resistance_Ohm;
  for (std::size_t j = 0; j < p.time_constant_s.size(); ++j) {
    const bool there = p.resistance_Ohm[j] > 0.0;
    json[fmt::format("r_{}", j + 1)] = p.resistance_Ohm[j];
    json[fmt::format("tau_{}", j + 1)] = there ? Json(p.time_constant_s[j]) : Json(nullptr);
  }
  return json;
}

void TellWhetherConverged(const std::vector<NamedFit>& fits, StudyResult& result) {
  std::vector<std::string> names;
  const PulseFitResult* first = nullptr;
  for (const auto& [name, fit] : fits) {
    if (fit->termination == Termination::kConverged) continue;
    if (first == nullptr) first = fit;
    names.push_back(name);
  }
  result.facts["converged"] = names.empty();
  if (names.empty()) return;
  const std::string which =
      names.size() == fits.size()
          ? "all fits"
          : fmt::format("the fit{} with {}", names.size() == 1 ? "" : "s", fmt::join(names, ", "));
  result.remarks.push_back(
      fmt::format("not converged: {}. {} Such a row is not the best that this cell can do: raise "
                  "solver.max_iterations before the table is believed",
                  which,
                  first->message));
}

}  // namespace lipoid
