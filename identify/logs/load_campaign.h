#pragma once

/// @file
/// The logs of a campaign, read and made those of one cell.
/// Tests: tests/identify/logs/load_campaign_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/logs/campaign.h"
#include "identify/logs/log.h"

namespace lipoid {

struct LoadedLog {
  CampaignLog entry;
  Log log;                             ///< voltages and currents of one cell
  bool temperature_predicted = false;  ///< by a heat balance: nobody measured it
  bool ambient_doubted = false;        ///< the cell rests far from the ambient_degC of its entry
};

/// Reads every log by ReadLogs(), in the order of the campaign. The LoadErrors of all bad files come
/// as one; a file that is bad in several places of the campaign is named once.
[[nodiscard]] std::vector<LoadedLog> LoadCampaign(const Campaign& campaign);

/// The same of logs that were read already, or that a program hands over, in the order of the
/// campaign. Where neither packs nor leads change a column, it stays lent.
[[nodiscard]] std::vector<LoadedLog> TakeLogs(const Campaign& campaign, std::vector<Log> logs);

/// Whether alpha only scales the axis of what was measured over charge: no log says that it starts
/// elsewhere than full.
[[nodiscard]] bool AllStartFull(const std::vector<LoadedLog>& logs);

/// The state of charge at which every log starts that is fitted; none where they differ, which moves
/// them against one another with alpha.
[[nodiscard]] std::optional<double> CommonStart(const std::vector<LoadedLog>& logs);

/// The mean temperature of the cell while charge moved, in the pulses or, where there are none, in all logs
/// that are fitted; none where one of them does not tell it.
[[nodiscard]] std::optional<double> LoadedTemperature_degC(const std::vector<LoadedLog>& logs);

/// What the temperatures of the logs must span, so that activation energies can be told from other
/// differences between the logs.
inline constexpr double kLeastSpan_K = 10.0;

/// Of the cell at the first row, as the log or its entry has it; NaN: not told.
[[nodiscard]] double StartTemperature(const LoadedLog& log);

/// Why a fit that knows no temperature, as the staged method, should not take these logs as one: they
/// begin more than kLeastSpan_K apart. "" where they do not, or do not say. Logs of kind validation do
/// not count.
[[nodiscard]] std::string DoubtAboutOneTemperature(const std::vector<LoadedLog>& logs);

/// What a reader of any result should know of the logs, one sentence each: whose sign other logs
/// settled, and which two logs of one format count their current in opposite ways.
[[nodiscard]] std::vector<std::string> NotesOnLogs(const std::vector<LoadedLog>& logs);

}  // namespace lipoid
