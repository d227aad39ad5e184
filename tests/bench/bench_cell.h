#pragma once

/// @file
/// The cell and the pulse log that the benchmarks of stage 3 work on.

#include <algorithm>
#include <cmath>
#include <random>

#include "identify/logs/record.h"
#include "model/battery/cell.h"
#include "model/battery/prediction.h"

namespace lipoid::bench {

inline constexpr double kNoise_V = 2e-4;
inline constexpr double kSampling_s = 0.01;

/// The cell of Table 4.11 on a made-up curve, with branches a decade apart.
inline Cell BenchCell(int terms, int branches) {
  Cell cell;
  cell.capacity_Ah = 0.376;
  cell.diffusion = Cell::Diffusion{.alpha_C = 1353.6, .beta_per_sqrt_s = 0.1924, .terms = terms};
  cell.series_resistance_Ohm = Resistance<double>(0.1314);
  for (int j = 0; j < branches; ++j) {
    cell.branches.push_back({.resistance_Ohm = Resistance<double>(0.03),
                             .time_constant_s = 45.0 * std::pow(0.1, j),
                             .capacitance_F = {}});
  }
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (int k = 0; k <= 200; ++k) {
    const double a = -0.05 + 1.05 * k / 200;
    soc.push_back(a);
    voltage_V.push_back(3.7 + 0.4 * a - 0.6 * std::exp(-30.0 * (a + 0.05)));
  }
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
  return cell;
}

/// `count` rounds of `load_s` at current_A and `rest_s` of rest, with 0.2 mV of noise.
inline Record BenchLog(
    const Cell& cell, int count, double current_A, double load_s, double rest_s) {
  Record record;
  const auto round = static_cast<std::size_t>((load_s + rest_s) / kSampling_s);
  const std::size_t rows = static_cast<std::size_t>(count) * round + 1;
  record.time_s.resize(rows);
  record.current_A.resize(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    record.time_s[k] = static_cast<double>(k) / 100.0;
    const bool load = k > 0 && static_cast<double>((k - 1) % round) * kSampling_s < load_s;
    record.current_A[k] = load ? current_A : 0.0;
  }
  record.voltage_V = Predict(cell, record.time_s, record.current_A).voltage_V;
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  for (double& v : record.voltage_V) v += kNoise_V * normal(engine);
  return record;
}

/// So many rows of the thesis' pulses: 30 s of load in half an hour, at 6C or at what makes nine
/// tenths of the charge last until the end.
inline Record BenchLogOfRows(const Cell& cell, std::size_t rows) {
  constexpr double kLoad_s = 30.0;
  constexpr double kRest_s = 1770.0;
  const double most_A = 3.6;
  const auto rounds =
      static_cast<int>(std::ceil(static_cast<double>(rows) * kSampling_s / (kLoad_s + kRest_s)));
  const double current_A = std::min(most_A, 0.9 * cell.alpha_C() / (rounds * kLoad_s));
  Record record = BenchLog(cell, rounds, current_A, kLoad_s, kRest_s);
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) column->resize(rows);
  return record;
}

}  // namespace lipoid::bench
