#pragma once

/// @file
/// Heat capacity and thermal resistance of a cell from the temperatures that were measured on it,
/// once the rest of the cell is known: the heat follows from currents and voltages of the cell, and
/// the temperature above the surroundings is its low pass.
///
///   (T - T_ambient)' = (R_th q - (T - T_ambient))/tau,   tau = C R_th
///
/// is linear in R_th for a given tau, which is searched. Surroundings that are not told are as warm
/// as the cell at the first row. Tests: tests/identify/joint/heat_fit_test.cc.

#include <optional>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "model/battery/cell.h"

namespace lipoid {

struct HeatFit {
  HeatBalance<double> balance;
  double rmse_K = 0.0;          ///< of the temperature above the surroundings, every log the same
  double largest_rise_K = 0.0;  ///< that was measured
  std::size_t logs = 0;         ///< with a temperature
  /// Whether the entropic slope of the cell takes part in the heat: not where the temperatures are
  /// explained better without.
  bool reversible = true;
  double rmse_reversible_K = 0.0;  ///< with the heat of the entropic slope
  /// By leaving out one log after the other; NaN of fewer than three.
  double heat_capacity_standard_error_J_per_K = 0.0;
  double thermal_resistance_standard_error_K_per_W = 0.0;
  double covariance_s = 0.0;  ///< of the two: J/K K/W
};

/// What logs must show of their own warming.
inline constexpr double kLeastRise_K = 2.0;

/// Of the logs but those of kind validation. None where no log has temperatures that rise by
/// kLeastRise_K, or the heat does not explain them. The cell is one that knows temperature.
[[nodiscard]] std::optional<HeatFit> FitHeat(const Cell& cell, const std::vector<LoadedLog>& logs);

/// What FitHeat() would find in logs of a cell that is known, by the same least squares: the balance
/// of the cell, and the standard errors that a thermometer gives whose readings are off by
/// temperature_noise_K, independently from row to row. None as there, and where the cell has no
/// balance.
[[nodiscard]] std::optional<HeatFit> PlanHeat(const Cell& cell,
                                              const std::vector<LoadedLog>& logs,
                                              double temperature_noise_K);

}  // namespace lipoid
