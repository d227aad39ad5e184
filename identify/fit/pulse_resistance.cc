#include "identify/fit/pulse_resistance.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/joint/joint_sweep.h"
#include "identify/trust/cell_uncertainty.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

std::string Name(double after_s) { return fmt::format("R({})", after_s); }

// The state of charge moves during the test, and with it the resistances: steps are no longer than this.
constexpr double kLongestStep_s = 0.5;

// The test as a log: at rest first, then a point after each time. Points on the way have no weight, and
// no row.
JointLogs TestOf(const JointRates& rates,
                 const JointSetup& setup,
                 double typical_A,
                 const PulseQuestion& question) {
  JointLog log;
  log.delivered_C = setup.AxisCharge(rates.alpha_C) * (1.0 - question.soc);
  // Where alpha is searched a log says how full it begins, and not which charge is gone.
  if (std::isfinite(rates.alpha_C)) log.delivered_C *= setup.alpha_C / rates.alpha_C;
  const auto add = [&](double time_s, double step_A, double current_A, double weight) {
    log.time_s.push_back(time_s);
    log.step_A.push_back(step_A);
    log.current_A.push_back(current_A);
    log.voltage_V.push_back(0.0);
    log.count.push_back(weight);
    log.weight.push_back(weight);
    log.group.push_back(JointLog::kAlways);
    log.stretch.push_back(JointLog::kAlways);
    log.unit.push_back(JointLog::kAlways);
  };
  add(0.0, 0.0, 0.0, 1.0);
  log.steps.to.push_back(0);
  for (const double after_s : question.after_s) {
    const double from_s = log.time_s.back();
    const int steps = static_cast<int>(std::ceil((after_s - from_s) / kLongestStep_s));
    const double step_s = (after_s - from_s) / steps;
    for (int k = 1; k <= steps; ++k) {
      log.steps.to.push_back(static_cast<std::uint32_t>(log.steps.length_s.size()));
      const bool last = k == steps;
      add(last ? after_s : from_s + k * step_s,
          question.current_A,
          question.current_A,
          last ? 1.0 : 0.0);
    }
    log.steps.length_s.push_back(step_s);
  }
  log.rows = log.size();
  if (question.temperature_degC) {
    const double temperature_K = *question.temperature_degC + kZeroCelsius_K;
    log.temperature_K.assign(log.size(), temperature_K);
    log.warm_steps = log.steps;
    log.warm_steps.at_K.assign(log.steps.length_s.size(), temperature_K);
  }
  JointLogs logs;
  logs.logs.push_back(std::move(log));
  logs.typical_A = typical_A;
  logs.largest_A = question.current_A;
  return logs;
}

// Rows of R i in the nonlinear parameters, then the linear ones; its values are the residuals.
FittedRows Drops(const JointSolution& solution,
                 const JointSetup& setup,
                 double typical_A,
                 const PulseQuestion& question) {
  JointRates rates = solution.rates;
  if (std::isfinite(rates.current_offset_A))
    rates.current_offset_A = 0.0;  // of a sensor, not of the cell
  const JointLogs test = TestOf(rates, setup, typical_A, question);
  FittedRows rows = JointObservations(test, setup).Rows(solution.structure, rates, solution.x)[0];
  const Eigen::RowVectorXd rest = rows.sensitivity.row(0);
  rows.sensitivity = (-rows.sensitivity).rowwise() + rest;
  rows.residual_V.array() -= rows.residual_V[0];  // nothing was measured: minus what is predicted
  return rows;
}

}  // namespace

std::vector<double> PulseResistancesOf(const JointSolution& solution,
                                       const JointSetup& setup,
                                       double typical_A,
                                       const PulseQuestion& question) {
  if (solution.x.size() == 0)
    return std::vector<double>(question.after_s.size(), std::numeric_limits<double>::quiet_NaN());
  const FittedRows drops = Drops(solution, setup, typical_A, question);
  std::vector<double> found_Ohm;
  for (Eigen::Index k = 1; k < drops.residual_V.size(); ++k)
    found_Ohm.push_back(drops.residual_V[k] / question.current_A);
  return found_Ohm;
}

std::vector<NamedCombination> PulseResistancesIn(const LinearizedFit& fit,
                                                 const JointSolution& solution,
                                                 const JointSetup& setup,
                                                 double typical_A,
                                                 const PulseQuestion& question) {
  const Eigen::MatrixXd rows =
      fit.Project(Drops(solution, setup, typical_A, question).sensitivity, solution);
  std::vector<NamedCombination> found;
  for (std::size_t k = 0; k < question.after_s.size(); ++k) {
    found.push_back({Name(question.after_s[k]),
                     rows.row(static_cast<Eigen::Index>(k) + 1).transpose() / question.current_A,
                     {}});
  }
  return found;
}

void TakePulseResistances(const std::vector<double>& values_Ohm,
                          const PulseQuestion& question,
                          TrustReport& trust,
                          const std::vector<double>& beside_Ohm) {
  const double freedom = MiddleFreedom(trust);
  for (std::size_t k = 0; k < values_Ohm.size(); ++k) {
    const auto at = std::find(trust.drawn.begin(), trust.drawn.end(), Name(question.after_s[k]));
    double reach_Ohm = std::numeric_limits<double>::infinity();
    if (at != trust.drawn.end()) {
      const auto index = at - trust.drawn.begin();
      const double variance = trust.drawn_covariance(index, index);
      const double beside = beside_Ohm.empty() ? 0.0 : beside_Ohm[k];
      if (freedom > 0.0 && variance > 0.0)
        reach_Ohm = Reach95(freedom) * std::hypot(std::sqrt(variance), beside);
    }
    trust.resistance.push_back({.after_s = question.after_s[k],
                                .current_A = question.current_A,
                                .temperature_degC = question.temperature_degC,
                                .resistance_Ohm = values_Ohm[k],
                                .low_Ohm = std::max(values_Ohm[k] - reach_Ohm, 0.0),
                                .high_Ohm = values_Ohm[k] + reach_Ohm});
  }
  std::erase_if(trust.drawn, [](const std::string& name) { return name.starts_with("R("); });
  const auto left = static_cast<Eigen::Index>(trust.drawn.size());
  trust.drawn_covariance.conservativeResize(left, left);
}

}  // namespace lipoid
