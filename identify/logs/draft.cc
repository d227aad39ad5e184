#include "identify/logs/draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <limits>

#include "identify/median.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

// Cut-offs are round numbers.
constexpr double kCutoffStep_V = 0.05;
// Rates closer than this are the same test twice.
constexpr double kSameRate = 0.1;

double RoundToDigits(double value, int digits) {
  const double step = std::pow(10.0, std::floor(std::log10(value)) + 1 - digits);
  // Through decimal text, so that 33.1 does not become 33.100000000000001.
  return std::stod(fmt::format("{:.12g}", std::round(value / step) * step));
}

double Tolerance(const Discharge& discharge) {
  return std::max(kCutoffTolerance_V, 3.0 * discharge.voltage_noise_V);
}

// Text that stays within its comment, whatever the name of a file is.
std::string Comment(std::string text) {
  for (char& c : text) {
    if (static_cast<unsigned char>(c) < 0x20) c = ' ';
  }
  return "# " + text + "\n";
}

struct Candidate {
  const Inspection* inspection = nullptr;
  CampaignDraft::Entry* entry = nullptr;
};

// The voltage at which most discharges end: a round one where they allow it.
double FindCutoff(const std::vector<Candidate>& discharges) {
  std::vector<double> ends_V;
  ends_V.reserve(discharges.size());
  for (const Candidate& each : discharges)
    ends_V.push_back(each.inspection->discharge->end_voltage_V);
  const double middle_V = UpperMedian(std::move(ends_V));
  const double round_V = RoundToDigits(std::round(middle_V / kCutoffStep_V) * kCutoffStep_V, 3);
  const double fine_V = RoundToDigits(std::ceil(middle_V * 1000.0) / 1000.0, 4);
  return std::abs(round_V - middle_V) <= 2.0 * kCutoffTolerance_V ? round_V : fine_V;
}

// Whether `a` tells more about the open-circuit voltage than `b`.
bool BetterLowRate(const Candidate& a, const Candidate& b) {
  const double slower = a.inspection->discharge->current_A / b.inspection->discharge->current_A;
  if (slower < 1.0 - kSameRate) return true;
  if (slower > 1.0 / (1.0 - kSameRate)) return false;
  const double resistance_a = a.inspection->edge_resistance_Ohm;
  const double resistance_b = b.inspection->edge_resistance_Ohm;
  return resistance_a < resistance_b || (std::isnan(resistance_b) && !std::isnan(resistance_a));
}

}  // namespace

std::vector<std::string> FilesOfFolder(const std::string& folder) {
  constexpr std::array<std::string_view, 8> kNoLogs = {
      ".cff", ".json", ".md", ".pdf", ".png", ".py", ".toml", ".yaml"};
  std::vector<std::string> files;
  std::error_code trouble;
  for (fs::directory_iterator each(folder, trouble), end; !trouble && each != end;
       each.increment(trouble)) {
    const std::string name = each->path().filename().string();
    const std::string extension = each->path().extension().string();
    const bool no_log = std::find(kNoLogs.begin(), kNoLogs.end(), extension) != kNoLogs.end();
    if (each->is_regular_file() && name[0] != '.' && !no_log)
      files.push_back(each->path().string());
  }
  if (trouble)
    throw LoadError({.file = folder},
                    fmt::format("expected a folder of logs, found {}", trouble.message()));
  if (files.empty())
    throw LoadError({.file = folder}, "expected a folder of logs, found none in it");
  std::sort(files.begin(), files.end());
  return files;
}

CampaignDraft DraftCampaign(const std::vector<InspectedFile>& files,
                            const std::string& name,
                            const std::string& campaign_file,
                            const ReadOptions& read) {
  CampaignDraft draft;
  draft.campaign.name = name;
  const fs::path base = fs::absolute(campaign_file).parent_path();
  const auto relative = [&](const std::string& file) {
    const fs::path path =
        fs::absolute(file).lexically_normal().lexically_relative(base.lexically_normal());
    return path.empty() ? fs::absolute(file).string() : path.generic_string();
  };
  draft.entries.reserve(files.size());  // candidates point into it
  std::vector<Candidate> fast;
  std::vector<Candidate> slow;
  const Inspection* slowest = nullptr;
  for (const InspectedFile& file : files) {
    if (!file.inspection) {
      const auto& problem = file.problems.front();
      draft.unused.emplace_back(relative(file.file), problem.message);
      continue;
    }
    const Inspection& inspection = *file.inspection;
    if (!inspection.suggestion.kind) {
      draft.unused.emplace_back(relative(file.file), inspection.suggestion.reason);
      continue;
    }
    CampaignDraft::Entry entry;
    entry.log.kind = *inspection.suggestion.kind;
    entry.log.file = relative(file.file);
    entry.log.path = file.file;
    entry.log.read = read;
    // The log that settled this one may not be in the campaign.
    if (inspection.report.current_sign_is_of_others) {
      entry.log.read.current_sign = inspection.report.current_sign;
    }
    entry.reason = inspection.suggestion.reason;
    draft.entries.push_back(std::move(entry));
    const Candidate candidate{&inspection, &draft.entries.back()};
    if (draft.entries.back().log.kind == LogKind::kConstantCurrent) fast.push_back(candidate);
    if (draft.entries.back().log.kind == LogKind::kLowRate) slow.push_back(candidate);
    if (!inspection.discharge) continue;
    if (slowest == nullptr || inspection.discharge->current_A < slowest->discharge->current_A)
      slowest = &inspection;
  }
  if (slowest != nullptr) {
    draft.campaign.capacity_Ah = RoundToDigits(slowest->discharge->charge_C / 3600.0, 3);
  }
  if (!fast.empty() || !slow.empty())
    draft.campaign.cutoff_V = FindCutoff(fast.empty() ? slow : fast);
  for (const Candidate& each : fast) {
    const Discharge& discharge = *each.inspection->discharge;
    if (discharge.end_voltage_V <= *draft.campaign.cutoff_V + Tolerance(discharge)) continue;
    each.entry->left_out =
        fmt::format("ends at {:.4g} V, above the cut-off", discharge.end_voltage_V);
  }
  if (!slow.empty()) {
    const Candidate best = *std::min_element(slow.begin(), slow.end(), &BetterLowRate);
    for (const Candidate& each : slow) {
      if (each.entry == best.entry) continue;
      const bool slower = best.inspection->discharge->current_A <
                          (1.0 - kSameRate) * each.inspection->discharge->current_A;
      each.entry->left_out =
          slower ? fmt::format("{} is slower", best.entry->log.file)
                 : fmt::format(
                       "as slow as {}, whose first edge shows {:.3g} Ohm instead of {:.3g} Ohm",
                       best.entry->log.file,
                       best.inspection->edge_resistance_Ohm,
                       each.inspection->edge_resistance_Ohm);
    }
  }
  for (const auto& entry : draft.entries) {
    if (entry.left_out.empty()) draft.campaign.logs.push_back(entry.log);
  }
  return draft;
}

std::string DraftToToml(const CampaignDraft& draft) {
  Campaign head = draft.campaign;
  head.logs.clear();
  std::string text =
      "# Drafted by lipoid inspect: read it over, most of all capacity, cut-off and kinds.\n";
  text += CampaignToToml(head);
  for (const auto& entry : draft.entries) {
    text += "\n" + Comment(entry.reason);
    const std::string lines = CampaignLogToToml(entry.log);
    if (entry.left_out.empty()) {
      text += lines;
      continue;
    }
    text += Comment(fmt::format("Left out: {}.", entry.left_out));
    for (std::size_t start = 0; start < lines.size();) {
      const std::size_t end = lines.find('\n', start);
      text += Comment(lines.substr(start, end - start));
      start = end + 1;
    }
  }
  if (!draft.unused.empty()) text += "\n# Not used:\n";
  for (const auto& [file, reason] : draft.unused) {
    text += Comment(fmt::format("  {}: {}", file, reason));
  }
  return text;
}

}  // namespace lipoid
