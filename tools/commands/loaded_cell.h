#pragma once

/// @file
/// The cell that a command is given, and what its own file says against it.

#include <string>

#include "model/battery/cell.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// A message where the fit that made the cell is doubtful.
void TellAboutFit(cli::CommandLine& line, const Cell& cell, const std::string& name);

/// LoadCell() of model/battery/cell_file.h with that message. A cell whose file gives it no name has that of the file.
[[nodiscard]] Cell LoadCell(cli::CommandLine& line, const std::string& name_or_file);

}  // namespace lipoid
