#pragma once

/// @file
/// Pulses of a cell whose numbers are known, without noise, for tests of what the fit of pulses says.

#include "identify/logs/record.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"

namespace lipoid::test {

inline constexpr double kPulseBeta = 0.12;
inline constexpr double kPulseSeries_Ohm = 0.08;
inline constexpr double kPulseTau_s = 25.0;

/// Eight pulses of 60 s with 900 s of rest, once a second; the rests are short for the diffusion. A
/// branch of 0 Ohm is none.
inline Record PulseRecord(double branch_Ohm, int terms = kUsualModes) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.diffusion->beta_per_sqrt_s = kPulseBeta;
  cell.diffusion->terms = terms;
  cell.series_resistance_Ohm = kPulseSeries_Ohm;
  cell.branches.clear();
  if (branch_Ohm > 0.0) {
    cell.branches.emplace_back();
    cell.branches[0].resistance_Ohm = branch_Ohm;
    cell.branches[0].time_constant_s = kPulseTau_s;
  }
  Record record;
  for (int k = 0; k <= 8 * 960; ++k) {
    record.time_s.push_back(k);
    record.current_A.push_back(k > 0 && (k - 1) % 960 < 60 ? 2.4 : 0.0);
  }
  record.voltage_V = Predict(cell, record.time_s, record.current_A).voltage_V;
  return record;
}

}  // namespace lipoid::test
