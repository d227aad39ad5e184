#include "identify/trust/experiment_plan.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/logs/record.h"
#include "identify/stages/staged_trust.h"
#include "identify/synthesis/decimal_step.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr std::size_t kMostRows = 40'000'000;
constexpr double kTypicalSoc = 0.5;

bool IsTooFast(const Cell::Branch& branch, double sampling_s) {
  return branch.time_constant_s < 0.5 * sampling_s;
}

// The cell with constants only: what stage 3 fits.
CellParameters<double> Constants(const Cell& cell) {
  CellParameters<double> p;
  p.alpha_C = cell.alpha_C();
  p.diffusion = cell.diffusion.has_value();
  if (cell.diffusion) {
    p.beta_per_sqrt_s = cell.diffusion->beta_per_sqrt_s;
    p.terms = cell.diffusion->terms;
    p.tail = cell.diffusion->tail;
  }
  p.series_resistance_Ohm = Resistance<double>(cell.series_resistance_Ohm(kTypicalSoc));
  for (const auto& branch : cell.branches)
    p.branches.push_back(
        {Resistance<double>(branch.resistance_Ohm(kTypicalSoc)), branch.time_constant_s});
  p.open_circuit_voltage = cell.open_circuit_voltage;
  return p;
}

Record SimulatePulses(const CellModel<double>& model,
                      const Cell& cell,
                      const TestPlan& plan,
                      const DecimalStep& sampling) {
  Record record;
  record.file = plan.file;
  RecordStepper<double> stepper(model, record.hold, model.Relaxed(1.0));
  std::size_t stage = 0;
  std::int64_t left = sampling.Count(plan.stages[0].length_s);
  for (std::int64_t row = 0;; ++row) {
    const double current_A = row == 0 ? 0.0 : plan.stages[stage].current_A;
    const double time_s = sampling.Times(row);
    stepper.Row(time_s, current_A);
    record.time_s.push_back(time_s);
    record.current_A.push_back(current_A);
    record.voltage_V.push_back(stepper.Voltage());
    if (record.voltage_V.back() <= cell.cutoff_V) break;
    if (record.size() >= kMostRows) {
      throw OptionError(fmt::format(
          "a plan of more than {} rows; take a longer sampling or shorter rests", kMostRows));
    }
    if (stepper.state().delivered_C > 3.0 * cell.alpha_C())
      throw OptionError("the cell never reaches its cut-off; give it another v_oc(A) or cut-off");
    if (row == 0 || --left > 0) continue;
    do {
      stage = (stage + 1) % plan.stages.size();
      left = sampling.Count(plan.stages[stage].length_s);
    } while (left == 0);
  }
  return record;
}

}  // namespace

PlannedExperiment PlanExperiment(const Cell& cell,
                                 const SynthesisOptions& options,
                                 const PlannedNoise& noise) {
  const auto sampling = DecimalStep::Of(options.sampling_s);
  if (!sampling) {
    throw OptionError(
        fmt::format("sampling: expected at most nine decimals, found {} s", options.sampling_s));
  }
  if (options.pulse_s < options.sampling_s) {
    throw OptionError(fmt::format(
        "a pulse of {} s is shorter than the sampling, {} s", options.pulse_s, options.sampling_s));
  }
  const CellModel<double> model(Constants(cell));
  const auto plans = ThesisProtocol(cell, options);
  const TestPlan& pulses = plans.back();
  const Record record = SimulatePulses(model, cell, pulses, *sampling);
  const auto& p = model.parameters();
  const VoltageSweep sweep({.alpha_C = p.alpha_C,
                            .diffusion = p.diffusion,
                            .terms = p.terms,
                            .tail = p.tail,
                            .open_circuit_voltage = p.open_circuit_voltage},
                           {{.record = &record}});
  PulseFitResult fit;
  fit.parameters.beta_per_sqrt_s = p.diffusion ? p.beta_per_sqrt_s : 1.0;
  fit.parameters.series_resistance_Ohm = p.series_resistance_Ohm(kTypicalSoc);
  for (const auto& branch : p.branches) {
    fit.parameters.resistance_Ohm.push_back(branch.resistance_Ohm(kTypicalSoc));
    fit.parameters.time_constant_s.push_back(branch.time_constant_s);
  }
  fit.solution = SolutionOf(fit.parameters);
  TrustOptions assume;
  assume.assumed = ResidualCorrelation{.white_V = noise.white_V,
                                       .correlated_V = noise.coloured_V,
                                       .correlation_s = noise.correlation_s};
  return {.current_A = pulses.stages[0].current_A,
          .duration_s = record.time_s.back(),
          .rows = record.size(),
          .trust = AssessStaged(sweep, fit, std::nullopt, assume)};
}

Cell AsSampled(const Cell& cell, double sampling_s) {
  Cell seen = cell;
  std::erase_if(seen.branches, [&](const Cell::Branch& branch) {
    if (!IsTooFast(branch, sampling_s)) return false;
    for (std::size_t k = 0; k < seen.series_resistance_Ohm.resistance_Ohm.size(); ++k) {
      seen.series_resistance_Ohm.resistance_Ohm[k] += branch.resistance_Ohm(
          seen.series_resistance_Ohm.constant() ? kTypicalSoc : seen.series_resistance_Ohm.soc[k]);
    }
    return true;
  });
  return seen;
}

std::vector<std::string> LeftOutOfPlan(const Cell& cell, double sampling_s) {
  std::vector<std::string> left_out{
      "alpha and v_oc(A) are taken as known, as the staged fit takes them"};
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    const Cell::Branch& branch = cell.branches[j];
    if (!IsTooFast(branch, sampling_s)) continue;
    left_out.push_back(
        fmt::format("branch {} is too fast to be seen in rows every {:g} s (tau_{} = {:.3g} s): its "
                    "{:.3g} Ohm count with r_s",
                    j + 1,
                    sampling_s,
                    j + 1,
                    branch.time_constant_s,
                    branch.resistance_Ohm(kTypicalSoc)));
  }
  bool tables = !cell.series_resistance_Ohm.constant();
  for (const auto& branch : cell.branches) tables = tables || !branch.resistance_Ohm.constant();
  if (tables) {
    left_out.emplace_back(
        "resistances that depend on the state of charge count with their value at half charge");
  }
  if (cell.self_heating || cell.charge_transfer)
    left_out.emplace_back("self-heating and charge transfer of the cell are not in the plan");
  return left_out;
}

}  // namespace lipoid
