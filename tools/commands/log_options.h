#pragma once

/// @file
/// The options that say how logs are read, common to the commands that read them.

#include <functional>
#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// The files of all their logs.
[[nodiscard]] std::vector<std::string> LogFiles(const std::vector<Campaign>& campaigns);

/// LoadCampaign(), with a message for each of NotesOnLogs() and the first fifth of the progress bar, or of
/// that part of it which `share_of_bar` makes of a share.
[[nodiscard]] std::vector<LoadedLog> LoadLogs(
    cli::CommandLine& line,
    const Campaign& campaign,
    const std::function<double(double)>& share_of_bar = {});

}  // namespace lipoid
