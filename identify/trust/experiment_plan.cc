#include "identify/trust/experiment_plan.h"

#include <fmt/format.h>

#include <cmath>

#include "identify/stages/staged_trust.h"
#include "identify/synthesis/plan_walk.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr std::int64_t kMostRows = 40'000'000;
constexpr double kTypicalSoc = 0.5;

bool IsTooFast(const Cell::Branch& branch, double sampling_s) {
  return branch.time_constant_s < 0.5 * sampling_s;
}

// One cell with constants only: what stage 3 fits.
Cell Constants(const Cell& pack) {
  Cell cell = pack.AsOne();
  cell.series_resistance_Ohm = Resistance<double>(cell.series_resistance_Ohm(kTypicalSoc));
  for (auto& branch : cell.branches)
    branch.resistance_Ohm = Resistance<double>(branch.resistance_Ohm(kTypicalSoc));
  cell.self_heating.reset();
  cell.charge_transfer.reset();
  cell.temperature.reset();
  cell.hysteresis.reset();
  return cell;
}

}  // namespace

DecimalStep SamplingOf(const SynthesisOptions& options) {
  const auto sampling = DecimalStep::Of(options.sampling_s);
  if (!sampling) {
    throw OptionError(
        fmt::format("sampling: expected at most nine decimals, found {} s", options.sampling_s));
  }
  return *sampling;
}

Record RecordOfPlan(const Cell& cell, const TestPlan& plan, const DecimalStep& sampling) {
  Record record;
  record.file = plan.file;
  WalkPlan(cell, plan, sampling, record.hold, kMostRows, [&](const WalkedRow& row) {
    // A cycler stops pulses at the cut-off. A discharge ends in the first row below it: without that row it would
    // not be one down to the cut-off.
    if (plan.kind == LogKind::kPulses && row.voltage_V < cell.cutoff_V) return;
    record.time_s.push_back(row.time_s);
    record.current_A.push_back(row.current_A);
    record.voltage_V.push_back(row.voltage_V);
    if (plan.ambient_degC)
      record.temperature_degC.push_back(row.stepper.state().temperature_K - kZeroCelsius_K);
  });
  return record;
}

PlannedExperiment PlanExperiment(const Cell& cell,
                                 const SynthesisOptions& options,
                                 const PlannedNoise& noise) {
  const DecimalStep sampling = SamplingOf(options);
  const Cell constant = Constants(cell);
  const CellParameters<double> p = constant.Parameters();
  const auto plans = ThesisProtocol(cell, options);
  const TestPlan& pulses = plans.back();
  PlannedExperiment planned;
  planned.refused = WhyNoPulses(constant, pulses, sampling);
  if (!planned.refused.empty()) return planned;
  const Record record = RecordOfPlan(constant, pulses, sampling);
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
  planned.current_A = pulses.stages[0].current_A;
  planned.duration_s = record.time_s.back();
  planned.rows = record.size();
  planned.trust = AssessStaged(sweep, fit, std::nullopt, assume);
  return planned;
}

Cell AsSampled(const Cell& cell, double sampling_s) {
  Cell seen = cell;
  for (std::size_t j = 0; j < seen.branches.size();) {
    const Cell::Branch& branch = seen.branches[j];
    if (!IsTooFast(branch, sampling_s)) {
      ++j;
      continue;
    }
    for (std::size_t k = 0; k < seen.series_resistance_Ohm.resistance_Ohm.size(); ++k) {
      seen.series_resistance_Ohm.resistance_Ohm[k] += branch.resistance_Ohm(
          seen.series_resistance_Ohm.constant() ? kTypicalSoc : seen.series_resistance_Ohm.soc[k]);
    }
    const auto at = static_cast<std::ptrdiff_t>(j);
    seen.branches.erase(seen.branches.begin() + at);
    if (seen.temperature) {
      auto& energies = seen.temperature->branches_J_per_mol;
      energies.erase(energies.begin() + at);
    }
  }
  return seen;
}

std::optional<std::string> TooFastForPlan(const Cell& cell, std::size_t j, double sampling_s) {
  const Cell::Branch& branch = cell.branches[j];
  if (!IsTooFast(branch, sampling_s)) return std::nullopt;
  return fmt::format(
      "branch {} is too fast to be seen in rows every {:g} s (tau_{} = {:.3g} s): its "
      "{:.3g} Ohm count with r_s",
      j + 1,
      sampling_s,
      j + 1,
      branch.time_constant_s,
      branch.resistance_Ohm(kTypicalSoc));
}

std::vector<std::string> TermsLeftOut(const Cell& cell, bool constants) {
  std::vector<std::string> terms;
  bool tables = !cell.series_resistance_Ohm.constant();
  for (const auto& branch : cell.branches) tables = tables || !branch.resistance_Ohm.constant();
  if (constants && tables) terms.emplace_back("resistance over the state of charge");
  if (constants && cell.charge_transfer) terms.emplace_back("charge transfer");
  if (cell.self_heating) terms.emplace_back("self-heating");
  if (cell.hysteresis) terms.emplace_back("hysteresis");
  return terms;
}

std::vector<std::string> LeftOutOfPlan(const Cell& cell, double sampling_s) {
  std::vector<std::string> left_out{
      "alpha and v_oc(A) are taken as known, as the staged fit takes them"};
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    if (auto said = TooFastForPlan(cell, j, sampling_s)) left_out.push_back(std::move(*said));
  }
  for (const std::string& term : TermsLeftOut(cell, true))
    left_out.push_back(fmt::format("{} of the cell is not in the plan{}",
                                   term,
                                   term.starts_with("resistance")
                                       ? ": resistances count with their value at half charge"
                                       : ""));
  return left_out;
}

}  // namespace lipoid
