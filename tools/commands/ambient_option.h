#pragma once

/// @file
/// The temperature of the air about a cell that is to fly: --ambient-degC.

#include <string>

#include "model/battery/cell.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// The cell as it is where it knows temperature. Else with typical energies and the heat of a cell of
/// this size, and a message that says so.
[[nodiscard]] Cell KnowingTemperature(cli::CommandLine& line,
                                      const Cell& cell,
                                      const std::string& cell_name,
                                      double size_factor = 1.0);

}  // namespace lipoid
