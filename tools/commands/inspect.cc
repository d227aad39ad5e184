// lipoid inspect LOG... | FOLDER: what is in logs, and a campaign drafted from them.
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>

#include "identify/logs/draft.h"
#include "identify/logs/inspection.h"
#include "identify/logs/inspection_report.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/reading_request.h"
#include "identify/logs/thinning.h"
#include "identify/pack_request.h"
#include "model/core/atomic_file.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/json.h"
#include "tools/cli/shell_word.h"
#include "tools/cli/text_table.h"
#include "tools/commands.h"
#include "tools/report/log_series.h"

namespace lipoid {
namespace {

using cli::Align;

constexpr double kSecondsPerHour = 3600.0;
// Of more segments than kMostSegments only the first and the last few are printed; the summary has
// them all.
constexpr std::size_t kMostSegments = 12;
constexpr std::size_t kFirstSegments = 7;
constexpr std::size_t kLastSegments = 3;

template <class E>
std::string Name(E value) {
  return options_internal::ToText(value);
}

std::string KindName(const Suggestion& suggestion) {
  return suggestion.kind ? Name(*suggestion.kind) : "none";
}

std::string Duration(double s) {
  if (s < 180.0) return fmt::format("{:.4g} s", s);
  if (s < 3.0 * kSecondsPerHour) return fmt::format("{:.1f} min", s / 60.0);
  if (s < 72.0 * kSecondsPerHour) return fmt::format("{:.1f} h", s / kSecondsPerHour);
  return fmt::format("{:.1f} days", s / (24.0 * kSecondsPerHour));
}

std::string FromTo(const Spread& spread, std::string_view unit) {
  if (spread.least == spread.largest) return fmt::format("{:.5g} {}", spread.least, unit);
  return fmt::format("{:.5g} {} to {:.5g} {}", spread.least, unit, spread.largest, unit);
}

std::string Sampling(const Spread& s) {
  if (s.median <= 0.0) return "";
  std::string text = fmt::format(", a row every {:.4g} s", s.median);
  // The last digits of time stamps are rounded.
  if (s.largest - s.least > 0.01 * s.median)
    text += fmt::format(" ({:.4g} s to {:.4g} s)", s.least, s.largest);
  return text;
}

// "1 of 2, 6 cells in series and 30 Ah as the autopilot was told".
std::string BatteryText(const FlightFacts& flight) {
  std::string text = fmt::format("{} of {}", flight.battery, flight.batteries.size());
  std::vector<std::string> told;
  if (flight.cells > 0) told.push_back(fmt::format("{} in series", Counted(flight.cells, "cell")));
  if (std::isfinite(flight.capacity_Ah))
    told.push_back(fmt::format("{:.4g} Ah", flight.capacity_Ah));
  if (!told.empty()) text += fmt::format("; {} as the autopilot was told", fmt::join(told, ", "));
  return text;
}

std::string CountsByKind(const std::vector<Segment>& segments) {
  std::vector<std::string> counts;
  for (const auto& [kind, name] : OptionNames(SegmentKind{})) {
    const auto count = static_cast<std::size_t>(
        std::count_if(segments.begin(), segments.end(), [k = kind](const Segment& segment) {
          return segment.kind == k;
        }));
    if (count > 0) counts.push_back(fmt::format("{} {}", count, name));
  }
  return fmt::format("{}", fmt::join(counts, ", "));
}

// Decimals that show five digits of the largest of some values.
int Decimals(double largest) {
  if (!(largest > 0.0)) return 1;
  return std::clamp(4 - static_cast<int>(std::floor(std::log10(largest))), 1, 9);
}

// Without the "-0.000" of what rounds to nothing.
std::string Fixed(double value, int decimals) {
  if (std::abs(value) < 0.5 * std::pow(10.0, -decimals)) value = 0.0;
  return fmt::format("{:.{}f}", value, decimals);
}

// Which step or cycle a row belongs to: "" where the file does not say.
std::string LabelOf(const std::vector<RowLabel>& labels, std::size_t row, double RowLabel::*which) {
  const auto after =
      std::upper_bound(labels.begin(), labels.end(), row, [](std::size_t r, const RowLabel& l) {
        return r < l.row;
      });
  return after == labels.begin() ? "" : fmt::format("{:g}", (*std::prev(after)).*which);
}

std::string SegmentTable(const Inspection& log, bool all) {
  const std::vector<Segment>& segments = log.segments;
  const std::vector<RowLabel>& labels = log.report.labels;
  std::vector<cli::TextTable::Column> columns{{"  segment", Align::kLeft},
                                              {"start / s"},
                                              {"duration / s"},
                                              {"current / A"},
                                              {"charge / Ah"}};
  if (!labels.empty()) columns.insert(columns.end(), {{"step"}, {"cycle"}});
  const std::size_t width = columns.size();
  cli::TextTable table(std::move(columns), "Segments of the log.");
  double most_A = 0.0;
  double most_Ah = 0.0;
  for (const Segment& segment : segments) {
    most_A = std::max(most_A, std::abs(segment.current_A));
    most_Ah = std::max(most_Ah, std::abs(segment.charge_C) / kSecondsPerHour);
  }
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (!all && segments.size() > kMostSegments && k == kFirstSegments) {
      k = segments.size() - kLastSegments;
      std::vector<std::string> more(width);
      more[0] = fmt::format("  ... {} more (--all shows them)",
                            segments.size() - kFirstSegments - kLastSegments);
      table.Row(std::move(more));
    }
    const Segment& segment = segments[k];
    std::vector<std::string> row{"  " + Name(segment.kind),
                                 fmt::format("{:.1f}", segment.start_s),
                                 fmt::format("{:.1f}", segment.duration_s()),
                                 Fixed(segment.current_A, Decimals(most_A)),
                                 Fixed(segment.charge_C / kSecondsPerHour, Decimals(most_Ah))};
    if (!labels.empty()) {
      row.push_back(LabelOf(labels, segment.first, &RowLabel::step));
      row.push_back(LabelOf(labels, segment.first, &RowLabel::cycle));
    }
    table.Row(std::move(row));
  }
  return table.Text();
}

// The tests within one file, and how to read each.
std::string PartsTable(const std::vector<Inspection>& parts) {
  cli::TextTable table({{"  part", Align::kLeft},
                        {"start_s"},
                        {"end_s"},
                        {"charge out / Ah"},
                        {"rests at / V"},
                        {"kind", Align::kLeft}},
                       "The parts of the log.");
  for (std::size_t k = 0; k < parts.size(); ++k) {
    const Inspection& part = parts[k];
    table.Row({fmt::format("  {}", k + 1),
               fmt::format("{:.10g}", part.part_start_s),
               fmt::format("{:.10g}", part.part_end_s),
               fmt::format("{:.4f}", part.charge_out_C / kSecondsPerHour),
               std::isnan(part.start_voltage_V) ? "-" : fmt::format("{:.4g}", part.start_voltage_V),
               KindName(part.suggestion)});
  }
  return table.Text();
}

// The reason may say the sign itself.
std::string Sign(const LogReport& report) {
  if (report.current_sign_reason.starts_with("discharge is ")) return report.current_sign_reason;
  return fmt::format("{}: {}", report.current_sign, report.current_sign_reason);
}

void PrintInspection(cli::CommandLine& line, const Inspection& log, bool all) {
  const auto item = [&](std::string_view name, const std::string& text) {
    constexpr std::size_t kColumn = 15;
    if (!text.empty()) line.Print("  {:<12} {}\n", name, cli::Wrapped(text, kColumn));
  };
  line.Print("{}\n", log.file);
  if (log.parts.empty()) {
    item("kind", fmt::format("{}: {}", KindName(log.suggestion), log.suggestion.reason));
  } else {
    item("kind",
         fmt::format("{}, between recharges or gaps; a draft reads each by its start_s and end_s",
                     Counted(log.parts.size(), "test")));
  }
  item("format", fmt::format("{}, {}", log.report.format, Counted(log.report.rows, "row")));
  if (log.report.flight) {
    const FlightFacts& flight = *log.report.flight;
    item("vehicle", flight.vehicle);
    item("battery", BatteryText(flight));
    item("updates",
         fmt::format("voltage each {:.3g} s, current each {:.3g} s",
                     flight.voltage_update_s,
                     flight.current_update_s));
  }
  item("time", Duration(log.duration_s) + Sampling(log.sampling_s));
  item("current", FromTo(log.current_A, "A"));
  item("sign", Sign(log.report));
  item("voltage", log.voltage_V ? FromTo(*log.voltage_V, "V") : "none");
  if (log.voltage_V && CellsInSeries(log.voltage_V->largest) > 1 &&
      (!log.report.flight || log.report.flight->cells == 0)) {
    item("pack",
         fmt::format("{} cells in series, by the voltage",
                     CellsInSeriesInWords(log.voltage_V->largest)));
  }
  if (log.temperature_degC) item("temperature", FromTo(*log.temperature_degC, "degC"));
  double in_gaps_C = 0.0;
  for (const Gap& gap : log.report.gaps) in_gaps_C += gap.unknown_C;
  item("charge",
       fmt::format("{:.4g} Ah out, {:.4g} Ah in{}",
                   log.charge_out_C / kSecondsPerHour,
                   log.charge_in_C / kSecondsPerHour,
                   in_gaps_C > 0.0
                       ? fmt::format(", {:.3g} Ah of it in gaps, had the current been held there",
                                     in_gaps_C / kSecondsPerHour)
                       : ""));
  item("dropped", DroppedText(log.report));
  if (log.report.thinned) item("thinned", ThinningText(*log.report.thinned));
  for (const auto& warning : log.report.warnings) item("look at", warning);
  for (const auto& note : log.report.notes) item("note", note);
  if (!log.parts.empty()) line.Print("{}", PartsTable(log.parts));
  item("segments", CountsByKind(log.segments));
  line.Print("{}\n", SegmentTable(log, all));
}

void PrintOverview(cli::CommandLine& line, const std::vector<InspectedFile>& files) {
  cli::TextTable table({{"log", Align::kFile},
                        {"format", Align::kLeft},
                        {"rows"},
                        {"duration"},
                        {"charge out / Ah"},
                        {"kind", Align::kLeft}},
                       "The logs.");
  for (const auto& file : files) {
    if (!file.inspection) {
      table.Row({file.file, "not read", "", "", "", ""});
      continue;
    }
    const Inspection& log = *file.inspection;
    table.Row({file.file,
               log.report.format,
               fmt::format("{}", log.report.rows),
               Duration(log.duration_s),
               fmt::format("{:.4f}", log.charge_out_C / kSecondsPerHour),
               log.parts.empty() ? KindName(log.suggestion) : Counted(log.parts.size(), "test")});
  }
  line.Print("{}", table.Text());
}

// The keys of a [[log]] that are not as they are anyway, and why.
Json ToJson(const CampaignDraft::Entry& entry) {
  const CampaignLog& log = entry.log;
  Json json = {{"file", log.path}, {"kind", Name(log.kind)}};
  if (log.read.current_sign != ReadOptions().current_sign)
    json["current_sign"] = log.read.current_sign;
  if (log.read.start_s != ReadOptions().start_s) json["start_s"] = log.read.start_s;
  if (log.read.end_s != ReadOptions().end_s) json["end_s"] = log.read.end_s;
  if (log.TellsStart()) json["initial_soc"] = log.initial_soc;
  json["reason"] = entry.reason;
  json["remarks"] = entry.remarks;
  json["left_out"] = entry.left_out.empty() ? Json(nullptr) : Json(entry.left_out);
  return json;
}

// What --write-campaign writes, for programs.
Json ToJson(const CampaignDraft& draft) {
  const Campaign& campaign = draft.campaign;
  Json json = {{"name", campaign.name},
               {"capacity_Ah", nullptr},
               {"cutoff_V", nullptr},
               {"series", campaign.series},
               {"parallel", campaign.parallel},
               {"remarks", draft.remarks},
               {"logs", Json::array()}};
  if (campaign.capacity_Ah > 0.0) json["capacity_Ah"] = campaign.capacity_Ah;
  if (campaign.cutoff_V) json["cutoff_V"] = *campaign.cutoff_V;
  for (const auto& entry : draft.entries) json["logs"].push_back(ToJson(entry));
  return json;
}

// Folders become the files in them.
std::vector<std::string> Expand(const std::vector<std::string>& words) {
  std::vector<std::string> files;
  for (const auto& word : words) {
    std::error_code none;
    if (!std::filesystem::is_directory(word, none)) {
      files.push_back(word);
      continue;
    }
    for (auto& file : FilesOfFolder(word)) files.push_back(std::move(file));
  }
  return files;
}

// A name for the cell: that of the folder.
std::string FolderName(const std::string& word) {
  auto path = std::filesystem::absolute(word).lexically_normal();
  if (std::error_code none; !std::filesystem::is_directory(path, none)) path = path.parent_path();
  if (path.filename().empty()) path = path.parent_path();
  return path.filename().string();
}

// What is to be done with logs of which no campaign can be drafted.
std::string NoDraft(const std::vector<InspectedFile>& files) {
  std::string text =
      "option --write-campaign: none of the logs is of a kind that a campaign takes, and none is "
      "written";
  const bool flights = std::all_of(files.begin(), files.end(), [](const InspectedFile& file) {
    return !file.inspection || file.inspection->report.flight;
  });
  if (flights)
    text +=
        "; flights are read by lipoid health --cell REFERENCE FLIGHT..., or by lipoid identify "
        "--flight FLIGHT";
  return text;
}

void WriteDraft(cli::CommandLine& line,
                const CampaignDraft& draft,
                const std::string& campaign_file) {
  if (draft.campaign.logs.empty()) {
    std::vector<std::string> why;
    for (const CampaignDraft::Entry& entry : draft.entries)
      why.push_back(fmt::format("{} {}", entry.log.file, entry.left_out));
    throw OptionError(
        fmt::format("option --write-campaign: every log is left out, and none is written: {}",
                    fmt::join(why, "; ")));
  }
  const bool a_file = campaign_file != "/dev/stdout";
  const std::string text = DraftToToml(draft);
  try {
    (void)ParseCampaign(text, campaign_file);
  } catch (const LoadError& error) {
    throw OptionError(
        fmt::format("option --write-campaign: these logs make no campaign that "
                    "identify reads, and none is written: {}",
                    error.diagnostics().front().message));
  }
  // A person may have edited the campaign of an earlier run.
  std::string kept;
  std::error_code none;
  if (a_file && std::filesystem::is_regular_file(campaign_file, none) &&
      ReadTextFile(campaign_file) != text) {
    kept = KeepCopy(campaign_file);
  }
  WriteFileAtomically(campaign_file, text);
  if (!a_file) return;
  if (!kept.empty()) {
    line.Message("{} held another campaign, perhaps edited: it is kept as {}", campaign_file, kept);
  }
  line.Message("{}: {}, {} left out, {} not used",
               campaign_file,
               Counted(draft.campaign.logs.size(), "log"),
               draft.entries.size() - draft.campaign.logs.size(),
               draft.unused.size());
  try {
    Campaign campaign = draft.campaign;
    campaign.file.clear();  // the message is about the logs, not about a place in the file
    CheckCampaign(campaign, false);
    std::vector<std::string_view> missing;
    if (!(campaign.capacity_Ah > 0.0)) missing.emplace_back("capacity_Ah");
    if (!campaign.cutoff_V) missing.emplace_back("cutoff_V");
    line.Message("Next: read it over{}, then lipoid identify {} -o cell.json",
                 missing.empty()
                     ? ""
                     : fmt::format(" and give {}, which no log shows", fmt::join(missing, " and ")),
                 cli::ShellWord(campaign_file));
  } catch (const OptionError& missing) {
    line.Message("These logs are not enough to identify the cell: {}", missing.what());
  }
}

}  // namespace

cli::ExitCode InspectCommand(cli::CommandLine& line) {
  std::vector<std::string> words;
  std::string campaign_file;
  bool all_segments = false;
  ReadingRequest reading;
  LoggedPackRequest pack;
  std::optional<double> cutoff_V;
  line.Describe(
      "Says what is in logs: format, sampling, sign, what was dropped, segments of rest and load, "
      "and the kind of test that each looks like.",
      "lipoid inspect cc_1C.csv pulses.csv");
  line.Example("lipoid inspect logs --write-campaign logs/campaign.toml");
  line.InputArguments("LOG", words, "logs, or folders of logs");
  line.OutputOption("write-campaign",
                    campaign_file,
                    "FILE",
                    "write a draft of a campaign of these logs, to be checked before it is used");
  line.Flag("all", all_segments, "print every segment, however many there are");
  line.Each(reading);
  line.Each(pack);
  line.Option("cutoff-V",
              cutoff_V,
              Range{0.0, 100.0},
              "voltage of one cell that ends a discharge, instead of finding it");
  line.ReportOption();
  if (!line.Parse()) return cli::ExitCode::kDone;

  ReadOptions read = reading.Resolve();
  read.labels = true;
  const auto named = Expand(words);
  line.AddInputs(named);
  if (named.size() == 1)
    read.progress = [&](double share) { line.progress().Update(share, "reading"); };
  const bool report = !line.report_file().empty();
  std::vector<Series> series(report ? named.size() : 0);
  constexpr std::size_t kColumns = 3;  // current, voltage, perhaps temperature
  const auto most_rows =
      RowsOfPage(std::vector<std::size_t>(named.size(), std::numeric_limits<int>::max()), kColumns);
  const auto draw = [&](std::size_t k, const Record& record) {
    series[k] = LogSeries({}, record, named[k], 1.0, most_rows[k]);
    series[k].of = k;
  };
  const auto files = InspectLogs(named, read, report ? SeenRecord(draw) : SeenRecord());
  for (Series& each : series) {
    if (each.rows > 0) line.report_series().push_back(std::move(each));
  }
  std::vector<Diagnostic> problems;  // the first of each bad file
  bool only_beside = true;  // of files that are no logs, and stand in a folder that was named
  Json rows = Json::array();
  for (const auto& file : files) {
    if (file.inspection) {
      if (files.size() > 1) cli::TablesForPaper::About(file.file);
      PrintInspection(line, *file.inspection, all_segments);
      rows.push_back(InspectionToJson(*file.inspection));
    } else {
      problems.push_back(file.problems.front());
      only_beside = only_beside && file.no_log &&
                    std::find(words.begin(), words.end(), file.file) == words.end();
      rows.push_back({{"file", file.file}, {"error", LoadError(file.problems).what()}});
    }
  }
  if (problems.size() == files.size())
    throw LoadError(files.size() == 1 ? files.front().problems : problems);
  cli::TablesForPaper::About("");
  if (files.size() > 1) PrintOverview(line, files);
  const bool a_file = !campaign_file.empty() && campaign_file != "/dev/stdout";
  const auto draft = DraftCampaign(files,
                                   FolderName(words.front()),
                                   a_file ? campaign_file : "campaign.toml",
                                   {.read = read,
                                    .series = pack.series,
                                    .parallel = pack.parallel.value_or(1),
                                    .cutoff_V = cutoff_V});
  const bool no_draft = !campaign_file.empty() && draft.entries.empty();
  if (no_draft) {
    line.Problem(LoadError(NoFile("lipoid inspect"), NoDraft(files)));
  } else if (!campaign_file.empty()) {
    WriteDraft(line, draft, campaign_file);
  }
  line.summary()["files"] = std::move(rows);
  line.summary()["draft"] = ToJson(draft);
  if (!problems.empty()) line.Problem(LoadError(std::move(problems)));
  if (!only_beside) return cli::ExitCode::kBadInput;
  return no_draft ? cli::ExitCode::kUsage : cli::ExitCode::kDone;
}

}  // namespace lipoid
