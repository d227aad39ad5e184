#pragma once

/// @file
/// The logs that a lab would make of a cell whose truth is known, with noise, for tests of the
/// estimators.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"

namespace lipoid::test {

/// White noise of the voltages in campaigns of the joint fit.
inline constexpr double kJointNoise_V = 0.0005;

/// A shipped cell with a branch that logs of minutes can see: 0.03 Ohm and 1500 F.
inline Cell Truth() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(0.03), 45.0, 1500.0}};
  return cell;
}

/// The same with activation energies and a heat balance.
inline Cell ColdTruth() {
  Cell cell = Truth();
  Cell::Temperature& term = cell.temperature.emplace();
  term.series_J_per_mol = 18e3;
  term.branches_J_per_mol = {45e3};
  term.diffusion_J_per_mol = 30e3;
  term.heat = HeatBalance<double>{15.0, 20.0};
  return cell;
}

/// A log of the cell under a current that is a function of time, to cut-off, sampled every dt_s;
/// voltages carry white noise.
template <class Current>
Record SimulateLog(const Cell& cell,
                   double dt_s,
                   double longest_s,
                   Current&& current_A,
                   const std::string& name,
                   double noise_V = 0.0,
                   std::uint64_t seed = 1) {
  Record record;
  record.file = name;
  for (int k = 0; k * dt_s <= longest_s; ++k) {
    record.time_s.push_back(k * dt_s);
    record.current_A.push_back(k == 0 ? 0.0 : current_A(k * dt_s));
  }
  record.voltage_V = Predict(cell, record.time_s, record.current_A).voltage_V;
  std::size_t rows = 0;
  while (rows < record.size() && record.voltage_V[rows] > cell.cutoff_V) ++rows;
  rows = std::min(rows + 1, record.size());
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) column->resize(rows);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> noise(0.0, 1.0);
  for (double& v : record.voltage_V) v += noise_V * noise(engine);
  return record;
}

inline LoadedLog AsLog(LogKind kind, Record record) {
  LoadedLog log;
  log.entry.kind = kind;
  log.entry.file = record.file;
  log.log.record = std::move(record);
  return log;
}

/// 1C, 3C and 6C of a 600 mAh cell, a low rate, and pulses of 30 s at 6C every half hour. `from` is
/// the first seed.
inline std::vector<LoadedLog> SyntheticLogs(const Cell& cell,
                                            double dt_s,
                                            double noise_V = 0.0,
                                            std::uint64_t from = 1) {
  std::vector<LoadedLog> logs;
  const double capacity_A = cell.capacity_Ah;
  for (const double rate : {1.0, 3.0, 6.0}) {
    const double current_A = rate * capacity_A;
    logs.push_back(AsLog(LogKind::kConstantCurrent,
                         SimulateLog(
                             cell,
                             dt_s,
                             1.5 * 3600.0 / rate,
                             [=](double) { return current_A; },
                             "cc_" + std::to_string(int(rate)) + "C.csv",
                             noise_V,
                             from++)));
  }
  logs.push_back(AsLog(LogKind::kLowRate,
                       SimulateLog(
                           cell,
                           10.0 * dt_s,
                           1e5,
                           [=](double) { return capacity_A / 12.0; },
                           "low_rate.csv",
                           noise_V,
                           from++)));
  logs.push_back(AsLog(
      LogKind::kPulses,
      SimulateLog(
          cell,
          dt_s,
          1e5,
          [=](double t) { return std::fmod(t - 1e-6, 1800.0) < 30.0 ? 6.0 * capacity_A : 0.0; },
          "pulses.csv",
          noise_V,
          from++)));
  return logs;
}

inline Campaign CampaignOf(const std::vector<LoadedLog>& logs, double capacity_Ah = 0.6) {
  Campaign campaign;
  campaign.name = "test cell";
  campaign.file = "campaign.toml";
  campaign.capacity_Ah = capacity_Ah;
  campaign.cutoff_V = 3.0;
  for (const auto& log : logs) campaign.logs.push_back(log.entry);
  return campaign;
}

/// White noise, and noise that takes half a minute to forget.
inline void AddColouredNoise(std::vector<LoadedLog>& logs,
                             double white_V,
                             double slow_V,
                             std::uint64_t seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (auto& log : logs) {
    Record& record = log.log.record;
    double slow = slow_V * normal(engine);
    for (std::size_t k = 0; k < record.size(); ++k) {
      if (k > 0) {
        const double keep = std::exp(-(record.time_s[k] - record.time_s[k - 1]) / 30.0);
        slow = keep * slow + slow_V * std::sqrt(1.0 - keep * keep) * normal(engine);
      }
      record.voltage_V[k] += slow + white_V * normal(engine);
    }
  }
}

}  // namespace lipoid::test
