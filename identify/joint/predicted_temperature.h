#pragma once

/// @file
/// Logs that tell the temperature of their surroundings alone, beside others that show how a cell warms, or
/// as all logs do: then it warms as a typical cell of its capacity.
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
  HeatBalance<double> by;
  bool assumed = false;  ///< the balance is a typical one

  /// The logs with half of the rise above their surroundings. A fan, a holder or a box makes the thermal resistance
  /// of a cell a few times smaller or larger than a typical one: half of a rise that rests on it is its standard
  /// deviation.
  [[nodiscard]] std::vector<LoadedLog> HalfAsWarm() const;

  /// What to say where the fit took them, and where it fits better without, as a sentence.
  [[nodiscard]] std::string Predicted() const;
  [[nodiscard]] std::string NotTaken() const;
};

/// Whether a log that takes part in the fit has the temperature of its cell.
[[nodiscard]] bool TellTemperature(const std::vector<LoadedLog>& logs);

/// Of a cell with temperature. An entropic slope of logs without a thermometer is none that heats: it takes
/// up what the assumed temperatures miss.
void AssumeHeat(const HeatBalance<double>& heat, Cell& cell);

/// The temperature in every row of the logs that have `ambient_degC` alone and take part in the fit, by
/// the heat balance of this cell, or by a typical one where no log could have told it. None where it has no
/// heat balance, or would warm in none of them by a kelvin.
[[nodiscard]] std::optional<PredictedTemperatures> PredictTemperatures(
    const Cell& cell, const std::vector<LoadedLog>& logs);

}  // namespace lipoid
