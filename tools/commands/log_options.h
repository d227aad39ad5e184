#pragma once

/// @file
/// The options that say how logs are read, common to the commands that read them.

#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/logs/log.h"
#include "tools/cli/command_line.h"

namespace lipoid {

struct LogOptions {
  std::string units;         ///< "s,A,V"
  std::string current_sign;  ///< as typed
  Hold hold = Hold::kBackward;

  /// Adds --units, --current-sign and --hold.
  void AddTo(cli::CommandLine& line);
  /// OptionError where they are not right.
  [[nodiscard]] ReadOptions ToReadOptions() const;
};

/// LoadCampaign(), with a message for each of NotesOnLogs().
[[nodiscard]] std::vector<LoadedLog> LoadLogs(cli::CommandLine& line, const Campaign& campaign);

}  // namespace lipoid
