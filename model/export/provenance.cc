#include "model/export/provenance.h"

#include <fmt/format.h>

#include <algorithm>

#include "model/battery/curve_range.h"
#include "model/core/foreign_text.h"
#include "model/core/run_record.h"

namespace lipoid {
namespace {

// A sentence of lipoid's own may be longer than one value from elsewhere.
constexpr std::size_t kMostBytesOfSentence = 1000;

std::string ErrorText(const ExportError& error) {
  return fmt::format("{:.3f} mV rms, {:.3f} mV at most (at {:.1f} s, state of charge {:.3f})",
                     1e3 * error.rmse_V,
                     1e3 * error.max_error_V,
                     error.worst_s,
                     error.worst_soc);
}

// What the file itself begins with is another thing: most of them begin full.
std::string StartText(const ExportMission& mission) {
  if (mission.initial_soc == 1.0) return "";
  return fmt::format(", begun at a state of charge of {:.4g},", mission.initial_soc);
}

std::string ChargeErrorText(const ExportChargeError& error) {
  std::string text = fmt::format("{:.3f} % rms, {:.3f} % at most (at {:.1f} s)",
                                 1e2 * error.rms,
                                 1e2 * error.max_error,
                                 error.worst_s);
  if (error.lifetime_percent)
    text += fmt::format("; the time until empty is off by {:+.3f} %", *error.lifetime_percent);
  return text;
}

}  // namespace

// A line break is escaped by ForeignText; what ends a comment in C, XML or a template is parted.
std::string HarmlessInComment(std::string_view text, std::size_t most_bytes) {
  std::string safe = ForeignText(text, most_bytes);
  for (const std::string_view end : {"*/", "/*", "--", "#}", "\\"}) {
    for (std::size_t at = safe.find(end); at != std::string::npos; at = safe.find(end, at)) {
      if (end == "\\") {
        safe[at] = '?';  // a backslash at the end of a line would continue a C comment
      } else {
        safe.insert(at + 1, " ");
      }
    }
  }
  return safe;
}

std::string WithoutWhatNoTargetHolds(const ExportRequest& request) {
  if (!request.whole) return "";
  const bool both = request.whole->temperature && request.whole->hysteresis;
  return fmt::format(" without its {}{}{}",
                     request.whole->temperature ? "temperature" : "",
                     both ? " and " : "",
                     request.whole->hysteresis ? "hysteresis" : "");
}

std::string ButForTables(const Cell& cell) {
  for (const auto& branch : cell.branches) {
    if (branch.resistance_Ohm.constant()) continue;
    return ", but for the resistance of a branch that is a table over the state of charge: it is taken at the step's "
           "beginning, and steps that take under a hundredth of the charge keep it right";
  }
  return "";
}

std::vector<std::string> ProvenanceLines(const ExportRequest& request, const Exported& exported) {
  std::vector<std::string> lines;
  lines.push_back(fmt::format(
      "Made by lipoid {} from the cell {}.", Version(), HarmlessInComment(request.source)));
  lines.push_back(fmt::format("SHA-256 of the cell file: {}.", HarmlessInComment(request.sha256)));
  lines.push_back(fmt::format(
      "Pack: {} in series, {} in parallel.", request.cell.series, request.cell.parallel));
  if (const std::string doubt = DoubtAboutCurve(request.cell, 0.0, 1.0); !doubt.empty())
    lines.push_back(HarmlessInComment(doubt, kMostBytesOfSentence) + ".");
  if (exported.error || exported.charge_error) {
    lines.push_back(fmt::format(
        "Against the cell, over the mission {}{} with its current imposed{}:",
        HarmlessInComment(request.mission.name),
        StartText(request.mission),
        request.mission.hold == Hold::kForward ? ", that of a row until the next one" : ""));
  }
  if (exported.error) lines.push_back("  " + ErrorText(*exported.error) + ".");
  if (exported.naive)
    lines.push_back("  Numbers read off the cell file would give " + ErrorText(*exported.naive) +
                    ".");
  if (exported.charge_error)
    lines.push_back("  State of charge: " + ChargeErrorText(*exported.charge_error) + ".");
  if (exported.naive_charge_error)
    lines.push_back("  Numbers read off the cell file would give " +
                    ChargeErrorText(*exported.naive_charge_error) + ".");
  std::vector<std::string> cannot_hold = exported.cannot_hold;
  cannot_hold.insert(cannot_hold.end(), request.left_out.begin(), request.left_out.end());
  if (!cannot_hold.empty()) lines.emplace_back("What this law cannot hold:");
  for (const auto& what : cannot_hold)
    lines.push_back("  " + HarmlessInComment(what, kMostBytesOfSentence));
  for (const auto& note : exported.notes)
    lines.push_back(HarmlessInComment(note, kMostBytesOfSentence));
  return lines;
}

bool HasProvenance(std::string_view begin) {
  return begin.substr(0, kProvenanceBytes).find("Made by lipoid ") != std::string_view::npos;
}

std::string Commented(const std::vector<std::string>& lines, std::string_view sign) {
  constexpr std::size_t kColumns = 100;
  std::string text;
  for (const auto& line : lines) {
    const std::size_t indent = std::min(line.find_first_not_of(' '), line.size());
    const std::string margin(indent, ' ');
    std::string_view rest = std::string_view(line).substr(indent);
    do {
      const std::size_t room = kColumns - sign.size() - indent;
      std::size_t cut = rest.size();
      if (cut > room) {
        const std::size_t space = rest.rfind(' ', room);
        cut = space == std::string_view::npos || space == 0 ? room : space;
      }
      std::string row = fmt::format("{}{}{}", sign, margin, rest.substr(0, cut));
      row.erase(row.find_last_not_of(' ') + 1);
      text += row;
      text += '\n';
      rest.remove_prefix(std::min(rest.size(), rest.find_first_not_of(' ', cut)));
    } while (!rest.empty());
  }
  return text;
}

}  // namespace lipoid
