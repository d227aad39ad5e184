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

/// A message where the cell was never seen as cold or as warm as it is here.
void TellWhatIsExtrapolated(cli::CommandLine& line,
                            const Cell& cell,
                            const Surroundings& surroundings);

}  // namespace lipoid
