#include "identify/logs/campaign.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>

#include "identify/logs/campaign_request.h"
#include "model/battery/ranges.h"
#include "model/core/foreign_text.h"
#include "model/core/json.h"
#include "model/core/toml_reader.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 4> kColumns = {
    "time_s", "current_A", "voltage_V", "temperature_degC"};

template <class Names>
std::string List(const Names& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

void ReadUnits(const TomlReader& reader, ReadOptions& read) {
  const toml::node* node = reader.Find("units");
  if (node == nullptr) return;
  constexpr std::string_view kExpected =
      "the units of time, current and voltage, [\"s\", \"A\", \"V\"]";
  if (const auto* text = node->as_string()) {
    std::istringstream words(text->get());
    for (std::string word; std::getline(words, word, ',');) {
      const auto first = word.find_first_not_of(" \t");
      const auto last = word.find_last_not_of(" \t");
      read.units.push_back(first == std::string::npos ? "" : word.substr(first, last - first + 1));
    }
  } else if (const auto* list = node->as_array()) {
    for (const toml::node& item : *list) {
      if (!item.is_string()) return reader.Expected(item, "units", kExpected);
      read.units.push_back(item.as_string()->get());
    }
  }
  constexpr std::array<std::array<std::string_view, 4>, 3> kKnown = {
      {{"s", "min", "h", "ms"}, {"A", "mA", "", ""}, {"V", "mV", "", ""}}};
  bool right = read.units.size() == kKnown.size();
  for (std::size_t k = 0; right && k < kKnown.size(); ++k) {
    right = !read.units[k].empty() &&
            std::find(kKnown[k].begin(), kKnown[k].end(), read.units[k]) != kKnown[k].end();
  }
  if (right) return;
  reader.Problem(reader.At(node->source()),
                 fmt::format("units: expected {} (s, ms, min or h; A or mA; V or mV), found {}",
                             kExpected,
                             node->is_array() ? "[" + List(read.units) + "]" : TomlFound(*node)));
}

void ReadColumns(const TomlReader& reader, ReadOptions& read) {
  const toml::node* node = reader.Find("columns");
  if (node == nullptr) return;
  const auto* table = node->as_table();
  if (table == nullptr)
    return reader.Expected(*node, "columns", "a table, { time_s = \"name in the header\" }");
  for (const auto& [key, value] : *table) {
    if (std::find(kColumns.begin(), kColumns.end(), key.str()) == kColumns.end()) {
      reader.Problem(
          reader.At(key.source()),
          fmt::format("columns: expected one of {}, found '{}'", List(kColumns), key.str()));
    } else if (const auto number = value.value_exact<std::int64_t>(); number && *number > 0) {
      read.columns[std::string(key.str())] = std::to_string(*number);
    } else if (!value.is_string() || value.as_string()->get().empty()) {
      reader.Expected(value,
                      fmt::format("columns.{}", key.str()),
                      "the name of a column in quotes, or its number from 1");
    } else {
      read.columns[std::string(key.str())] = value.as_string()->get();
    }
  }
}

void ReadTemperature(const TomlReader& reader, std::string_view key, std::optional<double>& of) {
  double found_degC = 0.0;
  if (reader.Number(key,
                    kTemperatures_degC.lo,
                    kTemperatures_degC.hi,
                    "a temperature from -60 to 150 degC",
                    found_degC))
    of = found_degC;
}

CampaignLog ReadEntry(const TomlReader& reader, const fs::path& folder) {
  reader.OnlyKeys({"kind",
                   "file",
                   "hold",
                   "columns",
                   "units",
                   "current_sign",
                   "steps",
                   "cycles",
                   "start_s",
                   "end_s",
                   "battery",
                   "initial_soc",
                   "lead_resistance_Ohm",
                   "weight",
                   "ambient_degC",
                   "initial_degC"});
  CampaignLog log;
  log.position = reader.At();
  for (const std::string_view key : {"kind", "file"}) {
    if (reader.Find(key) == nullptr) {
      reader.Problem(reader.At(),
                     fmt::format("expected the key '{}' in this [[log]], found none", key));
    }
  }
  reader.Choice("kind", log.kind);
  if (reader.Text("file", log.file)) {
    log.position = reader.At(reader.Find("file")->source());
    log.path = (folder / log.file).lexically_normal().string();
  }
  reader.Choice("hold", log.read.hold);
  ReadColumns(reader, log.read);
  ReadUnits(reader, log.read);
  if (reader.Text("current_sign", log.read.current_sign)) {
    constexpr std::array<std::string_view, 3> kSigns = {
        "auto", "discharge-positive", "discharge-negative"};
    if (std::find(kSigns.begin(), kSigns.end(), log.read.current_sign) == kSigns.end()) {
      reader.Expected(*reader.Find("current_sign"), "current_sign", "one of " + List(kSigns));
    }
  }
  reader.Integers("steps", log.read.steps);
  reader.Integers("cycles", log.read.cycles);
  reader.Integer("battery", 1, kMostBatteries, log.read.battery);
  const double most = TomlReader::kLargest;
  reader.Number("start_s", -most, most, "a time in seconds", log.read.start_s);
  const bool end = reader.Number("end_s", -most, most, "a time in seconds", log.read.end_s);
  if (end && !(log.read.end_s > log.read.start_s)) {
    reader.Expected(
        *reader.Find("end_s"), "end_s", fmt::format("a time after start_s = {}", log.read.start_s));
  }
  log.initial_soc_told = reader.Number("initial_soc",
                                       kInitialSocs.lo,
                                       kInitialSocs.hi,
                                       "a state of charge from -0.5 to 1.5 (1 is full)",
                                       log.initial_soc);
  reader.Number("lead_resistance_Ohm",
                0.0,
                1000.0,
                "a resistance from 0 to 1000 Ohm",
                log.read.lead_resistance_Ohm);
  reader.Number("weight", kWeights.lo, kWeights.hi, "a number from 1e-6 to 1e6", log.weight);
  ReadTemperature(reader, "ambient_degC", log.ambient_degC);
  ReadTemperature(reader, "initial_degC", log.initial_degC);
  return log;
}

bool SamePart(const CampaignLog& a, const CampaignLog& b) {
  return a.kind == b.kind && a.path == b.path && a.read.steps == b.read.steps &&
         a.read.cycles == b.read.cycles && a.read.start_s == b.read.start_s &&
         a.read.end_s == b.read.end_s;
}

}  // namespace

void RefuseTwice(const Campaign& campaign, const CampaignLog& log) {
  for (const CampaignLog& other : campaign.logs) {
    if (!log.path.empty() && SamePart(log, other))
      throw OptionError(fmt::format("'{}' is given twice; name each log once", log.file));
  }
}

std::size_t Campaign::Count(LogKind kind) const {
  return static_cast<std::size_t>(std::count_if(
      logs.begin(), logs.end(), [&](const CampaignLog& log) { return log.kind == kind; }));
}

bool Campaign::OnlyFlights() const {
  return Count(LogKind::kFlight) > 0 && std::none_of(logs.begin(), logs.end(), [](const auto& log) {
           return TakesPartInLabFit(log.kind);
         });
}

Campaign ParseCampaign(const std::string& text, const std::string& file) {
  std::vector<Diagnostic> problems;
  const toml::table document = ParseToml(text, file, "a campaign");
  Campaign campaign;
  campaign.file = file;
  std::optional<double> ambient_degC;
  const TomlReader top(document, file, problems);
  top.OnlyKeys({"cell", "log"});
  if (const toml::node* node = top.Find("cell")) {
    if (const auto* table = node->as_table()) {
      const TomlReader cell(*table, file, problems);
      cell.OnlyKeys(
          {"name", "capacity_Ah", "cutoff_V", "series", "parallel", "ambient_degC", "age"});
      cell.Text("name", campaign.name);
      cell.Text("age", campaign.age);
      ReadTemperature(cell, "ambient_degC", ambient_degC);
      cell.Number("capacity_Ah",
                  TomlReader::kAboveZero,
                  1e6,
                  "a capacity above 0 Ah",
                  campaign.capacity_Ah);
      if (const auto* capacity = cell.Find("capacity_Ah"))
        campaign.capacity_position = cell.At(capacity->source());
      double cutoff_V = 0.0;
      if (cell.Number(
              "cutoff_V", 0.5, 6.0, "the cut-off of one cell, from 0.5 V to 6 V", cutoff_V)) {
        campaign.cutoff_V = cutoff_V;
        campaign.cutoff_position = cell.At(cell.Find("cutoff_V")->source());
      }
      cell.Integer("series", 1, static_cast<int>(kPackSizes.hi), campaign.series);
      cell.Integer("parallel", 1, static_cast<int>(kPackSizes.hi), campaign.parallel);
    } else {
      top.Expected(*node, "cell", "a table [cell]");
    }
  }
  const toml::node* logs = top.Find("log");
  const auto* list = logs != nullptr ? logs->as_array() : nullptr;
  if (logs == nullptr || (list != nullptr && list->empty())) {
    top.Problem({file}, "expected at least one [[log]], found none");
  } else if (list == nullptr) {
    top.Problem(top.At(logs->source()),
                fmt::format("expected [[log]], in double brackets, found {}",
                            logs->is_table() ? "[log]" : TomlFound(*logs)));
  } else {
    const fs::path folder = fs::path(file).parent_path();
    for (const toml::node& node : *list) {
      const auto* table = node.as_table();
      if (table == nullptr) {
        top.Expected(node, "log", "a table [[log]]");
        continue;
      }
      CampaignLog log = ReadEntry(TomlReader(*table, file, problems), folder);
      if (!log.ambient_degC) log.ambient_degC = ambient_degC;
      const auto twin =
          std::find_if(campaign.logs.begin(), campaign.logs.end(), [&](const CampaignLog& other) {
            return !log.path.empty() && SamePart(log, other);
          });
      if (twin != campaign.logs.end()) {
        top.Problem(
            log.position,
            fmt::format("expected each log once, found '{}' of kind {} again (first in line {})",
                        log.file,
                        options_internal::ToText(log.kind),
                        twin->position.line));
      }
      campaign.logs.push_back(std::move(log));
    }
  }
  ThrowProblems(std::move(problems));
  return campaign;
}

Campaign ReadCampaign(const std::string& file) {
  if (std::error_code none; fs::is_directory(file, none)) {
    const std::string inside = (fs::path(file) / "campaign.toml").string();
    throw LoadError(
        {file},
        "expected a campaign, found a folder; " +
            (fs::exists(inside, none)
                 ? fmt::format("its campaign is {}", ForeignText(inside))
                 : fmt::format("lipoid inspect {} --write-campaign {} drafts one of its logs",
                               ForeignText(file),
                               ForeignText(inside))));
  }
  const std::string text = ReadTextFile(file);
  if (fs::path(file).extension() == ".toml") return ParseCampaign(text, file);
  try {
    return ParseCampaign(text, file);
  } catch (const LoadError& error) {
    std::vector<Diagnostic> problems = error.diagnostics();
    if (!problems.front().message.starts_with("not a campaign in TOML")) throw;
    problems.front().message += fmt::format(
        ". If this is a log, lipoid inspect {} --write-campaign campaign.toml drafts a campaign",
        ForeignText(file));
    throw LoadError(std::move(problems));
  }
}

std::string CampaignLogToToml(const CampaignLog& log) {
  std::string text = fmt::format("[[log]]\nkind = \"{}\"\nfile = {}\n",
                                 options_internal::ToText(log.kind),
                                 TomlText(log.file));
  const auto add = [&](std::string_view key, const std::string& value) {
    text += fmt::format("{} = {}\n", key, value);
  };
  const ReadOptions defaults;
  const ReadOptions& read = log.read;
  if (read.hold != defaults.hold)
    add("hold", fmt::format("\"{}\"", options_internal::ToText(read.hold)));
  if (!read.columns.empty()) {
    std::vector<std::string> pairs;
    for (const auto& [key, name] : read.columns)
      pairs.push_back(fmt::format("{} = {}", key, TomlText(name)));
    add("columns", "{ " + List(pairs) + " }");
  }
  if (!read.units.empty()) {
    std::vector<std::string> units;
    for (const auto& unit : read.units) units.push_back(TomlText(unit));
    add("units", "[" + List(units) + "]");
  }
  if (!read.current_sign.empty()) add("current_sign", TomlText(read.current_sign));
  if (!read.steps.empty()) add("steps", "[" + List(read.steps) + "]");
  if (!read.cycles.empty()) add("cycles", "[" + List(read.cycles) + "]");
  if (read.start_s != defaults.start_s) add("start_s", TomlFloat(read.start_s));
  if (read.end_s != defaults.end_s) add("end_s", TomlFloat(read.end_s));
  if (read.battery != defaults.battery) add("battery", fmt::format("{}", read.battery));
  if (log.TellsStart()) add("initial_soc", TomlFloat(log.initial_soc));
  if (read.lead_resistance_Ohm != 0.0)
    add("lead_resistance_Ohm", TomlFloat(read.lead_resistance_Ohm));
  if (log.weight != CampaignLog().weight) add("weight", TomlFloat(log.weight));
  if (log.ambient_degC) add("ambient_degC", TomlFloat(*log.ambient_degC));
  if (log.initial_degC) add("initial_degC", TomlFloat(*log.initial_degC));
  return text;
}

std::string CampaignToToml(const Campaign& campaign) {
  std::string text = "[cell]\n";
  if (!campaign.name.empty()) text += fmt::format("name = {}\n", TomlText(campaign.name));
  if (campaign.capacity_Ah > 0.0)
    text += fmt::format("capacity_Ah = {}\n", TomlFloat(campaign.capacity_Ah));
  if (campaign.cutoff_V) text += fmt::format("cutoff_V = {}\n", TomlFloat(*campaign.cutoff_V));
  if (campaign.series != 1) text += fmt::format("series = {}\n", campaign.series);
  if (!campaign.age.empty()) text += fmt::format("age = {}\n", TomlText(campaign.age));
  if (campaign.parallel != 1) text += fmt::format("parallel = {}\n", campaign.parallel);
  for (const CampaignLog& log : campaign.logs) text += "\n" + CampaignLogToToml(log);
  return text;
}

void AddLogs(Campaign& campaign,
             LogKind kind,
             const std::vector<std::string>& files,
             const ReadOptions& read,
             double initial_soc) {
  for (const std::string& file : files) {
    CampaignLog log;
    log.kind = kind;
    log.file = file;
    log.path = fs::path(file).lexically_normal().string();
    log.read = read;
    log.initial_soc = initial_soc;
    RefuseTwice(campaign, log);
    campaign.logs.push_back(std::move(log));
  }
}

void RefuseCampaign(const Campaign& campaign, const std::string& message) {
  if (campaign.file.empty()) throw OptionError(message);
  throw LoadError({campaign.file}, message);
}

void CheckCampaign(const Campaign& campaign, bool open_circuit_voltage_given) {
  std::vector<std::string> problems;
  const bool typed = campaign.file.empty();
  if (campaign.OnlyFlights()) {
    if (campaign.capacity_Ah > 0.0) return;
    RefuseCampaign(
        campaign,
        fmt::format("expected the capacity of the cell, because flights alone do not tell it, "
                    "found none; give {}",
                    typed ? "--capacity-Ah" : "capacity_Ah in [cell]"));
  }
  if (campaign.Count(LogKind::kLowRate) + campaign.Count(LogKind::kPulses) == 0 &&
      !open_circuit_voltage_given) {
    problems.push_back(
        typed ? "expected a low-rate log for the open-circuit voltage, or pulses with rests, found "
                "neither; give one with --low-rate or --pulses, or the curve with "
                "--open-circuit-voltage FILE"
              : "expected a [[log]] of kind \"low-rate\" for the open-circuit voltage, or of kind "
                "\"pulses\" with rests, found neither; add one, or give the curve with "
                "--open-circuit-voltage FILE");
  }
  if (campaign.Count(LogKind::kConstantCurrent) + campaign.Count(LogKind::kPulses) == 0) {
    problems.push_back(
        typed
            ? "expected logs under load, found none; give discharges with --constant-current or "
              "pulses with --pulses"
            : "expected a [[log]] of kind \"constant-current\" or \"pulses\", found none; without "
              "a load no resistance can be identified");
  }
  if (campaign.Count(LogKind::kConstantCurrent) > 0 && !campaign.cutoff_V) {
    problems.push_back(
        typed
            ? "expected the cut-off voltage of the constant-current logs, found none; give it with "
              "--cutoff-V"
            : "expected cutoff_V in [cell], the voltage of one cell that ends the constant-current "
              "logs, found none");
  }
  if (problems.empty()) return;
  if (typed) throw OptionError(fmt::format("{}", fmt::join(problems, "\n")));
  std::vector<Diagnostic> diagnostics;
  diagnostics.reserve(problems.size());
  for (auto& problem : problems) diagnostics.push_back({{campaign.file}, std::move(problem)});
  throw LoadError(std::move(diagnostics));
}

}  // namespace lipoid
