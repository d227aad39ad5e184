#pragma once

/// @file
/// The noise of a thermometer, by which resistances would go to and fro from row to row: 0.05 K moves the drop of a cell
/// in the cold by more than its voltage is off, and a fit finds terms that are deaf to it. The cell itself
/// warms and cools over minutes. Tests: tests/identify/logs/thermometer_noise_test.cc.

#include <span>
#include <vector>

namespace lipoid {

/// Standard deviation of what is independent from row to row, by the median of second differences; 0 of fewer than
/// thirty rows.
[[nodiscard]] double ThermometerNoise(std::span<const double> shown);

/// For each row what a parabola through the rows around it has there: as many rows as leave residuals of
/// that noise, so that edges of a warming stay, and at most 128 to either side, fewer in logs of more than 125,000 rows.
[[nodiscard]] std::vector<double> WithoutThermometerNoise(std::span<const double> time_s,
                                                          std::span<const double> shown,
                                                          double noise);

}  // namespace lipoid
