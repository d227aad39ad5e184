#pragma once

/// @file
/// Which logs, and what is known of the cell: the options that all commands share which find
/// parameters by stages.

#include <optional>
#include <string>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/stages/staged_run.h"
#include "model/core/errors.h"
#include "model/core/json.h"
#include "tools/cli/command_line.h"
#include "tools/commands/log_options.h"
#include "tools/commands/start_options.h"

namespace lipoid {

class StagedArguments {
 public:
  StagedOptions options;
  StagedGiven given;

  /// Logs by options, --alpha-C, --open-circuit-voltage, --branches, --fix and their like.
  void AddTo(cli::CommandLine& line);
  /// --set of stages 1 to 3.
  void AddGroupsTo(cli::CommandLine& line);

  /// After Parse(): fills `options` and `given`; the campaigns of the files, or the one that the
  /// options describe. Their logs become inputs of the command line. OptionError where the options
  /// contradict each other, there is none, or an output is an input. Where `unreadable` is given,
  /// the LoadErrors of files that are no campaigns go there, and only the others are returned.
  [[nodiscard]] std::vector<Campaign> Campaigns(cli::CommandLine& line,
                                                const std::vector<std::string>& files,
                                                std::vector<LoadError>* unreadable = nullptr);
  /// Whether logs were given by options.
  [[nodiscard]] bool ByOptions() const;

  /// As --branches gave it.
  [[nodiscard]] int branches() const { return branches_.value_or(options.pulses.branches); }

  /// For the run record.
  [[nodiscard]] Json ToJson() const;

 private:
  CampaignArguments typed_;
  std::string curve_file_;
  LogOptions log_options_;
  StartOptions start_options_;
  std::optional<double> capacity_Ah_;
  std::optional<int> branches_;
  std::vector<std::string> fix_, start_, bounds_;
  bool no_diffusion_ = false;
};

}  // namespace lipoid
