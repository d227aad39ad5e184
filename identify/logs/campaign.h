#pragma once

/// @file
/// A campaign: all the logs of one cell, as a TOML file or as a list on the command line.
/// The format is described in docs/formats.md. Tests: tests/identify/logs/campaign_test.cc.

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/logs/log.h"
#include "model/core/errors.h"

namespace lipoid {

enum class LogKind { kConstantCurrent, kLowRate, kPulses, kValidation };

constexpr std::array<std::pair<LogKind, std::string_view>, 4> OptionNames(LogKind) {
  return {{{LogKind::kConstantCurrent, "constant-current"},
           {LogKind::kLowRate, "low-rate"},
           {LogKind::kPulses, "pulses"},
           {LogKind::kValidation, "validation"}}};
}

struct CampaignLog {
  LogKind kind = LogKind::kConstantCurrent;
  std::string file;       ///< as written, for reports
  std::string path;       ///< relative to the campaign file, resolved
  SourcePosition position;  ///< where it is named; file empty on the command line
  ReadOptions read;
  double initial_soc = 1.0;
  double weight = 1.0;
};

struct Campaign {
  std::string file;  ///< empty where it was given on the command line
  std::string name;
  double capacity_Ah = 0.0;  ///< nominal, of one cell; 0 where not given
  std::optional<double> cutoff_V;  ///< of one cell
  int series = 1;
  int parallel = 1;
  std::vector<CampaignLog> logs;
};

/// Strict: unknown keys and kinds, wrong types, values out of range are LoadErrors with line and column.
[[nodiscard]] Campaign ReadCampaign(const std::string& file);

/// The campaign as TOML text, as `inspect --write-campaign` writes it.
[[nodiscard]] std::string CampaignToToml(const Campaign& campaign);

}  // namespace lipoid
