#include "identify/trust/campaign_plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "identify/joint/joint_trust.h"
#include "identify/synthesis/plan_walk.h"
#include "model/battery/at_temperature.h"
#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"
#include "model/core/parallel.h"
#include "model/core/special_values.h"

namespace lipoid {
namespace {

// A thermometer has thousands of rows.
constexpr double kManyFreedoms = 1e4;

// The terms that such logs can show: they discharge, and what warms is the heat balance.
Cell AsPlanned(const Cell& pack) {
  Require(pack.temperature.has_value(), "a cell that knows temperature");
  Cell cell = pack.AsOne();
  cell.hysteresis.reset();
  cell.self_heating.reset();
  return cell;
}

// Where the joint fit of these logs would end if they had no noise. What lies beyond the range that
// they can show is planned at its limit: `beyond` then says so.
JointResult AtTheTruth(const Cell& cell,
                       const std::vector<LoadedLog>& logs,
                       std::vector<std::string>& beyond) {
  const HeldShape shape{.source = "", .cell = cell};
  JointResult result;
  result.alpha_C = cell.alpha_C();
  JointSetup& setup = result.setup;
  setup.alpha_C = cell.alpha_C();
  setup.diffusion = cell.diffusion.has_value();
  if (cell.diffusion) {
    setup.terms = cell.diffusion->terms;
    setup.tail = cell.diffusion->tail;
  }
  setup.slow_branches = true;  // the fit lets them in where left-out rows want them
  double deepest_C = 0.0;
  for (const LoadedLog& log : logs)
    deepest_C = std::max(deepest_C, DeliveredCharge(log.log.record).back());
  const double lowest_soc = 1.0 - deepest_C / setup.alpha_C;
  setup.open_circuit_voltage =
      AtNodes(cell.open_circuit_voltage, OnAxis(VoltageNodes(0), lowest_soc));
  result.logs = MakeJointLogs(logs, setup.alpha_C, setup.open_circuit_voltage, {});
  JointStructure structure;
  structure.branches = static_cast<int>(cell.branches.size());
  structure.resistance_soc = shape.ResistanceNodes();
  structure.voltage_soc = setup.open_circuit_voltage.soc();
  structure.charge_transfer = cell.charge_transfer.has_value();
  structure.temperature = cell.temperature.has_value();
  if (cell.temperature) {
    setup.reference_K = cell.temperature->reference_K;
    if (cell.temperature->entropy) structure.entropy_soc = OnAxis(EntropyNodes(), lowest_soc);
  }
  const JointObservations seen(result.logs, setup);
  const GivenParameters nothing;
  const JointFit fit(seen, nothing);
  JointRates rates = fit.Base(structure);
  std::vector<std::string> at_bound;
  for (const JointRate& rate : fit.Rates(structure)) {
    const double truth = CellParameter(cell, rate.name).value_or(rate.start);
    rate.In(rates) = std::clamp(truth, rate.lower, rate.upper);
    if (truth > rate.lower && truth < rate.upper) continue;
    at_bound.push_back(rate.name);
    const std::string unit(CellParameterUnit(rate.name));
    if (truth != rate.In(rates)) {
      beyond.push_back(fmt::format(
          "{} = {:.4g} {} instead of {:.4g} {}", rate.name, rate.In(rates), unit, truth, unit));
    }
  }
  // Of what `lipoid identify` chooses from, the least: smoothness that it does not choose would promise too much.
  result.choice.best = fit.Solve(structure, rates, kNoSmoothness);
  result.choice.best.at_bound = std::move(at_bound);
  if (result.choice.best.x.size() == 0)
    throw OptionError("these tests do not determine v_oc(A) and a resistance; take other ones");
  result.cutoff = CutoffOf(result.choice.best, result.logs, setup, cell.cutoff_V);
  return result;
}

QuantityTrust NotIdentifiable(const Cell& cell, const std::string& name) {
  QuantityTrust quantity = TrustOfEstimate(name,
                                           std::string(CellParameterUnit(name)),
                                           CellParameter(cell, name).value_or(0.0),
                                           kInfinity,
                                           0.0);
  quantity.insensitive = true;
  return quantity;
}

}  // namespace

std::vector<LoadedLog> PlannedLogs(const Cell& cell,
                                   const std::vector<TestPlan>& plans,
                                   const DecimalStep& sampling) {
  const Cell planned = AsPlanned(cell);
  std::vector<LoadedLog> logs(plans.size());
  ParallelFor(plans.size(), [&](std::size_t k) {
    Require(plans[k].ambient_degC.has_value(), "a plan at a temperature");
    LoadedLog& log = logs[k];
    log.entry.kind = plans[k].kind;
    log.entry.file = plans[k].file;
    log.entry.ambient_degC = plans[k].ambient_degC;
    log.log.record = RecordOfPlan(planned, plans[k], sampling);
  });
  return logs;
}

PlannedExperiment PlanCampaign(const Cell& cell,
                               const std::vector<TestPlan>& plans,
                               const DecimalStep& sampling,
                               const PlannedNoise& noise) {
  const Cell planned = AsPlanned(cell);
  PlannedExperiment plan;
  for (const TestPlan& test : plans) {
    if (test.kind != LogKind::kPulses) continue;
    plan.refused = WhyNoPulses(planned, test, sampling);
    if (!plan.refused.empty()) return plan;
    plan.current_A = test.stages[0].current_A;
  }
  const std::vector<LoadedLog> logs = PlannedLogs(planned, plans, sampling);
  plan.coldest_degC = kInfinity;
  plan.warmest_degC = -kInfinity;

  double sum_degC = 0.0;
  for (const LoadedLog& log : logs) {
    const Record& record = log.log.record;
    plan.duration_s += record.time_s.back();
    plan.rows += record.size();
    for (const double at_degC : record.temperature_degC) {
      plan.coldest_degC = std::min(plan.coldest_degC, at_degC);
      plan.warmest_degC = std::max(plan.warmest_degC, at_degC);
      sum_degC += at_degC;
    }
  }
  const bool told = plan.warmest_degC - plan.coldest_degC >= kLeastSpan_K;
  TrustOptions assume;
  assume.assumed = ResidualCorrelation{.white_V = noise.white_V,
                                       .correlated_V = noise.coloured_V,
                                       .correlation_s = noise.correlation_s};
  const double mean_degC = sum_degC / static_cast<double>(plan.rows);
  std::vector<std::string> beyond;
  plan.trust = AssessJoint(
      AtTheTruth(told ? planned : AtOneTemperature(planned, mean_degC), logs, beyond), assume);
  auto& quantities = plan.trust.quantities;
  const auto heat = told ? PlanHeat(planned, logs, noise.temperature_K) : std::nullopt;
  if (!told) {
    for (const std::string& name : CellParameterNames(planned)) {
      if (name.starts_with("E_")) quantities.push_back(NotIdentifiable(planned, name));
    }
  }
  if (heat) {
    quantities.push_back(TrustOfEstimate("C_th",
                                         "J/K",
                                         heat->balance.heat_capacity_J_per_K,
                                         heat->heat_capacity_standard_error_J_per_K,
                                         kManyFreedoms));
    quantities.push_back(TrustOfEstimate("R_th",
                                         "K/W",
                                         heat->balance.thermal_resistance_K_per_W,
                                         heat->thermal_resistance_standard_error_K_per_W,
                                         kManyFreedoms));
  } else if (planned.temperature->heat) {
    quantities.push_back(NotIdentifiable(planned, "C_th"));
    quantities.push_back(NotIdentifiable(planned, "R_th"));
  }
  if (!told) {
    plan.trust.sentence = fmt::format(
        "activation energies are not identifiable: the cell is between {:.1f} and {:.1f} degC, and "
        "telling what temperature does takes {:g} degC; apart from them, {}",
        plan.coldest_degC,
        plan.warmest_degC,
        kLeastSpan_K,
        plan.trust.sentence);
  }
  if (!beyond.empty()) {
    plan.trust.sentence =
        fmt::format("such logs show no more than their limits, at which the plan is made ({}): {}",
                    fmt::join(beyond, ", "),
                    plan.trust.sentence);
  }
  return plan;
}

bool OfTemperature(const std::string& name) {
  return name.starts_with("E_") || name == "C_th" || name == "R_th";
}

std::vector<std::string> LeftOutOfCampaign(const Cell& cell, double sampling_s) {
  std::vector<std::string> left_out{
      "the terms and the numbers of nodes and branches are taken as known: `lipoid identify` chooses "
      "them by left-out rows, and what that choice adds to an interval is not in these",
      "the fit lets every log count the same: one that says little of a parameter can make it a little "
      "less certain",
      "no smoothness of the tables and an activation energy of its own for each resistance are assumed: where "
      "`lipoid identify` chooses smoother tables or energies in common, it says smaller errors, of alpha most"};
  for (std::size_t j = 0; j < cell.branches.size(); ++j) {
    if (auto said = TooFastForPlan(cell, j, sampling_s)) left_out.push_back(std::move(*said));
  }
  for (const std::string& term : TermsLeftOut(cell, false))
    left_out.push_back(term + " of the cell is not in the plan");
  if (cell.temperature && !cell.temperature->heat) {
    left_out.emplace_back(
        "the cell file has no heat balance: the cell has the temperature of its surroundings");
  }
  if (cell.temperature_assumed)
    left_out.emplace_back("activation energies and heat balance of the cell are typical values");
  return left_out;
}

}  // namespace lipoid
