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

/// A message where a log has the temperature that options say, too.
void TellWhatIsMeasured(cli::CommandLine& line,
                        const Cell& cell,
                        const std::string& file,
                        const SurroundingsRequest& asked,
                        const Surroundings& surroundings);

/// A message where the cell was never seen as cold or as warm as it is in one of these.
void TellWhatIsExtrapolated(cli::CommandLine& line,
                            const Cell& cell,
                            std::span<const Surroundings> all);

/// Why temperature may be what a prediction is off by, as a message: the log was measured far from the
/// temperature of a cell that knows only one, or tells none to a cell that would know what it does.
void TellWhatTemperatureMayExplain(cli::CommandLine& line,
                                   const Cell& cell,
                                   const std::string& file,
                                   const Surroundings& surroundings);

}  // namespace lipoid
