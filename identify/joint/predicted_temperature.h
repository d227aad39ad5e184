#pragma once

/// @file
/// Logs that tell the temperature of their surroundings alone, beside others that show how a cell warms.
/// The diffusion of a cell that warms by 15 K is about twice as fast: fitted as if the cell stayed as cold as it was, such a
/// log bends everything that temperature moves. Tests: tests/identify/joint/joint_temperature_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "model/battery/cell.h"

namespace lipoid {

struct PredictedTemperatures {
  std::vector<LoadedLog> logs;     ///< of the campaign; some have a predicted temperature
  std::vector<std::string> files;  ///< of those some
  double most_K = 0.0;             ///< above their surroundings

  /// What to say where the fit took them, and where it fits better without, as a sentence.
  [[nodiscard]] std::string Predicted() const;
  [[nodiscard]] std::string NotTaken() const;
};

/// The temperature in every row of the logs that have `ambient_degC` alone and take part in the fit, by
/// the heat balance of this cell. None where it has no heat balance, or would warm in none of them by a kelvin.
[[nodiscard]] std::optional<PredictedTemperatures> PredictTemperatures(
    const Cell& cell, const std::vector<LoadedLog>& logs);

}  // namespace lipoid
