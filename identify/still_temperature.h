#pragma once

/// @file
/// Temperatures of logs that stand still while the cell must have warmed: those of the air, or of a thermometer that is
/// stuck. Tests: tests/identify/still_temperature_test.cc.

#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/logs/record.h"
#include "model/battery/cell.h"

namespace lipoid {

/// By how much one cell that starts at the first temperature of these rows would warm with the heat balance that is
/// typical of its size, where that is 5 K and more and the rows move by less than a tenth of it; 0 otherwise, and where
/// the rows have no temperature. What is typical may be wrong by a factor of two or three.
[[nodiscard]] double UnshownWarming_K(const Cell& cell, const Record& record, double initial_soc);

/// In a sentence, of which logs of tests the temperature does not show that the cell warms; "" of none. Cells that are
/// held at one temperature on purpose are told as well.
[[nodiscard]] std::string DoubtAboutStillTemperatures(const Cell& cell,
                                                      const std::vector<LoadedLog>& logs);

}  // namespace lipoid
