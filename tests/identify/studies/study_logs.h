#pragma once

/// @file
/// Logs of a known 600 mAh cell for the tests of the studies, and the campaign they make.

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "identify/studies/study.h"
#include "model/battery/prediction.h"

namespace lipoid::test {

inline constexpr double kStudyNoise_V = 5e-4;

/// `branches`: resistance and time constant of each.
inline Cell StudyCell(const std::vector<std::pair<double, double>>& branches, int terms = 10) {
  Cell cell;
  cell.capacity_Ah = 0.376;
  cell.cutoff_V = 3.0;
  cell.diffusion = Cell::Diffusion{.alpha_C = 1353.6, .beta_per_sqrt_s = 0.1924, .terms = terms};
  cell.series_resistance_Ohm = Resistance<double>(0.1314);
  for (const auto& [resistance_Ohm, time_constant_s] : branches) {
    cell.branches.push_back({.resistance_Ohm = Resistance<double>(resistance_Ohm),
                             .time_constant_s = time_constant_s,
                             .capacitance_F = {}});
  }
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(
      {0.0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0},
      {3.0, 3.3, 3.45, 3.6, 3.7, 3.74, 3.77, 3.82, 3.87, 3.95, 4.02, 4.11, 4.2});
  return cell;
}

/// Ten pulses of 30 s at 3.6 A with rests of 600 s, a row every second, white noise.
inline LoadedLog PulseLog(const Cell& cell, unsigned seed = 1) {
  LoadedLog log;
  log.entry.kind = LogKind::kPulses;
  log.entry.file = log.log.record.file = "pulses.csv";
  Record& record = log.log.record;
  for (int k = 0; k <= 10 * 630; ++k) {
    record.time_s.push_back(k);
    record.current_A.push_back(k > 0 && (k - 1) % 630 < 30 ? 3.6 : 0.0);
  }
  record.voltage_V = Predict(cell, record.time_s, record.current_A).voltage_V;
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal(0.0, kStudyNoise_V);
  for (double& v : record.voltage_V) v += normal(engine);
  return log;
}

/// A campaign of these logs for which alpha and v_oc(A) are known.
struct KnownCampaign {
  KnownCampaign(const Cell& cell, std::vector<LoadedLog> made) : logs(std::move(made)) {
    campaign.file = "campaign.toml";
    campaign.capacity_Ah = cell.capacity_Ah;
    campaign.cutoff_V = cell.cutoff_V;
    for (const auto& log : logs) campaign.logs.push_back(log.entry);
    given.alpha_C = cell.diffusion->alpha_C;
    given.open_circuit_voltage = cell.open_circuit_voltage;
  }
  [[nodiscard]] StudyInput Input() const {
    return {.campaign = campaign, .logs = logs, .options = options, .given = given};
  }

  Campaign campaign;
  std::vector<LoadedLog> logs;
  StagedOptions options;
  StagedGiven given;
};

inline void NoProgress(std::string_view, double) {}

}  // namespace lipoid::test
