#pragma once

/// @file
/// How warm a cell is in a prediction, common to the commands that predict.

#include <span>
#include <string>

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

/// Where the cell rests on no temperature and this log was measured far from that of a room, a message
/// that this may be why a prediction is off.
void TellWhatTemperatureMayExplain(cli::CommandLine& line,
                                   const Cell& cell,
                                   const std::string& file,
                                   std::span<const double> measured_degC);

}  // namespace lipoid
