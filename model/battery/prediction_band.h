#pragma once

/// @file
/// The interval of a predicted voltage: what cells drawn from the uncertainty of one cell would
/// show under the same current. Tests: tests/model/battery/prediction_band_test.cc.

#include <span>
#include <vector>

#include "model/battery/cell.h"
#include "model/battery/prediction.h"

namespace lipoid {

/// 95 % of the cells lie within, at each row by itself (model/statistics/interval_95.h).
struct PredictionBand {
  std::vector<double> voltage_low_V;
  std::vector<double> voltage_high_V;
};

/// Times, currents and voltages as Predict() has them; each cell with its own state of charge at
/// the start.
[[nodiscard]] PredictionBand PredictBand(std::span<const Cell> cells,
                                         std::span<const double> initial_soc,
                                         std::span<const double> time_s,
                                         std::span<const double> current_A,
                                         Hold hold = Hold::kBackward,
                                         const Surroundings& surroundings = {});

}  // namespace lipoid
