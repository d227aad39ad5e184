#pragma once

/// @file
/// Temperatures of logs that stand still while the cell must have warmed: those of the air, or of a thermometer that is
/// stuck. Tests: tests/identify/still_temperature_test.cc.

#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "model/battery/cell.h"

namespace lipoid {

/// In a sentence, of which logs of tests the temperature moves by less than a tenth of what this cell would warm by
/// with the heat balance that is typical of its size, where that is 5 K and more; "" of none. What is typical may be
/// wrong by a factor of two or three, and cells that are held at one temperature on purpose are told as well.
[[nodiscard]] std::string DoubtAboutStillTemperatures(const Cell& cell,
                                                      const std::vector<LoadedLog>& logs);

}  // namespace lipoid
