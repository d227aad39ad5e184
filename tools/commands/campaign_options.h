#pragma once

/// @file
/// Which logs: the options that all commands share which find parameters of a cell, where its logs
/// are given by options instead of a campaign file.

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/campaign_request.h"
#include "identify/logs/reading_request.h"
#include "identify/pack_request.h"
#include "model/battery/open_circuit_voltage.h"
#include "model/core/errors.h"
#include "tools/cli/command_line.h"

namespace lipoid {

class CampaignOptions {
 public:
  void AddTo(cli::CommandLine& line);

  /// After Parse(): the campaigns of the files, or the one that the options describe, with `curve`
  /// for its --initial-voltage-V. Their logs become inputs of the command line. OptionError where
  /// the options contradict each other, there is none, or an output is an input. Where `unreadable`
  /// is given, the LoadErrors of files that are no campaigns go there, and only the others are
  /// returned.
  [[nodiscard]] std::vector<Campaign> Campaigns(cli::CommandLine& line,
                                                const std::vector<std::string>& files,
                                                const std::optional<OpenCircuitVoltage>& curve,
                                                std::vector<LoadError>* unreadable = nullptr);
  /// Whether logs were given by options.
  [[nodiscard]] bool ByOptions() const;

 private:
  std::map<LogKind, std::vector<std::string>> files_;
  ReadingRequest reading_;
  StartRequest start_;
  CampaignRequest request_;
};

}  // namespace lipoid
