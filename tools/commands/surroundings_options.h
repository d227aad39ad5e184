#pragma once

/// @file
/// How warm a cell is in a prediction, common to the commands that predict.

#include "identify/surroundings_request.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// A message where something is asked of a cell that knows no temperature.
void TellWhatSaysNothing(cli::CommandLine& line,
                         const Cell& cell,
                         const SurroundingsRequest& surroundings);

}  // namespace lipoid
