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

/// A flight takes no part in the fit of lab logs: it is assessed against the cell that they give
/// (identify/health/health.h). Flights alone give what they can (identify/health/flights_alone.h).
enum class LogKind { kConstantCurrent, kLowRate, kLowRateCharge, kPulses, kFlight, kValidation };

constexpr std::array<std::pair<LogKind, std::string_view>, 6> OptionNames(LogKind) {
  return {{{LogKind::kConstantCurrent, "constant-current"},
           {LogKind::kLowRate, "low-rate"},
           {LogKind::kLowRateCharge, "low-rate-charge"},
           {LogKind::kPulses, "pulses"},
           {LogKind::kFlight, "flight"},
           {LogKind::kValidation, "validation"}}};
}

/// Whether the fit of lab logs sees logs of this kind.
constexpr bool TakesPartInLabFit(LogKind kind) {
  return kind != LogKind::kFlight && kind != LogKind::kValidation;
}

struct CampaignLog {
  LogKind kind = LogKind::kConstantCurrent;
  std::string file;         ///< as written, for reports
  std::string path;         ///< relative to the campaign file, resolved
  SourcePosition position;  ///< where it is named; file empty on the command line
  ReadOptions read;
  double initial_soc = 1.0;
  bool initial_soc_told = false;  ///< whether the campaign says it, also where it says 1
  double weight = 1.0;
  std::optional<double> ambient_degC;  ///< of the surroundings; none: not told
  std::optional<double> initial_degC;  ///< of the cell at the first row; none: that of the ambient

  /// Whether somebody said where it starts, in a campaign or by another way.
  [[nodiscard]] bool TellsStart() const { return initial_soc_told || initial_soc != 1.0; }
};

struct Campaign {
  std::string file;  ///< empty where it was given on the command line
  std::string name;
  double capacity_Ah = 0.0;        ///< nominal, of one cell; 0 where not given
  std::optional<double> cutoff_V;  ///< of one cell
  int series = 1;
  int parallel = 1;
  std::string age;  ///< a date, or cycles; as written
  std::vector<CampaignLog> logs;
  /// Where these two stand in the file; its name is empty where they do not.
  SourcePosition capacity_position = {};
  SourcePosition cutoff_position = {};

  [[nodiscard]] std::size_t Count(LogKind kind) const;
  /// Whether there are flights and nothing else that a cell could be identified from.
  [[nodiscard]] bool OnlyFlights() const;
};

/// OptionError where the campaign has the same rows of this file under this kind already.
void RefuseTwice(const Campaign& campaign, const CampaignLog& log);

/// Strict: unknown keys and kinds, wrong types, values out of range are LoadErrors with line and
/// column, all of one file at once.
[[nodiscard]] Campaign ReadCampaign(const std::string& file);

/// The same from text that came from `file`.
[[nodiscard]] Campaign ParseCampaign(const std::string& text, const std::string& file);

/// The campaign as TOML text, as `inspect --write-campaign` writes it: reads back as the same
/// campaign.
[[nodiscard]] std::string CampaignToToml(const Campaign& campaign);

/// One [[log]] of it.
[[nodiscard]] std::string CampaignLogToToml(const CampaignLog& log);

/// Files of one kind, as the command line gives them, become logs of the campaign. OptionError where one
/// stands twice.
void AddLogs(Campaign& campaign,
             LogKind kind,
             const std::vector<std::string>& files,
             const ReadOptions& read,
             double initial_soc = 1.0);

/// What its logs do not allow: LoadError at the campaign's file, OptionError where there is none.
[[noreturn]] void RefuseCampaign(const Campaign& campaign, const std::string& message);

/// Whether the logs may be enough to identify a cell: a low-rate log, pulses or a given curve for
/// v_oc(A); pulses or constant currents; a cut-off for constant currents; a capacity for flights alone. Else as RefuseCampaign.
void CheckCampaign(const Campaign& campaign, bool open_circuit_voltage_given);

}  // namespace lipoid
