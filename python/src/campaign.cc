#include "python/src/campaign.h"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <utility>

#include "identify/logs/campaign_request.h"
#include "identify/pack_request.h"
#include "model/core/errors.h"
#include "python/src/convert.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

// The logs at these places of a campaign.
Campaign Part(const Campaign& campaign, const std::vector<std::size_t>& places) {
  Campaign part = campaign;
  part.logs.clear();
  for (const std::size_t k : places) part.logs.push_back(campaign.logs[k]);
  return part;
}

std::string SumOf(const Record& record) {
  std::string bytes;
  for (const Column* column :
       {&record.time_s, &record.current_A, &record.voltage_V, &record.temperature_degC}) {
    const auto of = std::as_bytes(std::span<const double>(*column));
    bytes.append(reinterpret_cast<const char*>(of.data()), of.size());
  }
  return Sha256OfBytes(bytes);
}

// One log of a campaign that is made of arguments: a path or a log, and what is said of it alone, by
// the keys of a campaign file.
void Add(LogKind kind,
         const nb::tuple& given,
         double initial_soc,
         Campaign& campaign,
         std::vector<std::optional<PythonLog>>& logs) {
  CampaignLog entry;
  entry.kind = kind;
  entry.initial_soc = initial_soc;
  entry.position.file.clear();
  Keywords keywords(nb::cast<nb::dict>(given[1]));
  keywords.Option("initial_soc", entry.initial_soc, kInitialSocs, "");
  keywords.Option("weight", entry.weight, kWeights, "");
  keywords.Option("ambient_degC", entry.ambient_degC, kTemperatures_degC, "");
  keywords.Option("initial_degC", entry.initial_degC, kTemperatures_degC, "");
  if (nb::isinstance<PythonLog>(given[0])) {
    const auto& log = *nb::cast<const PythonLog*>(given[0]);
    entry.file = log.log->record.file;
    logs.emplace_back(log);
  } else {
    entry.read = ReadingOf(keywords, {}, true);
    entry.file = PathOf(given[0]);
    entry.path = std::filesystem::path(entry.file).lexically_normal().string();
    RefuseTwice(campaign, entry);
    logs.emplace_back(std::nullopt);
  }
  keywords.Finish();
  campaign.logs.push_back(std::move(entry));
}

struct CampaignKeywords {
  Campaign campaign;
  std::vector<std::optional<PythonLog>> logs;

  void Declare(Keywords& keywords) {
    CampaignRequest request;
    StartRequest start;
    keywords.Each(request);
    request.ApplyTo(campaign);
    StartRequest::VisitOfSoc(start, keywords.EachOne());
    const double initial_soc = start.initial_soc.value_or(1.0);
    for (const auto& [kind, name] : OptionNames(LogKind{})) {
      const auto listed =
          keywords.Take(PythonName(name), "Logs", fmt::format("logs of the kind {}", name));
      if (!listed) continue;
      for (const nb::handle log : *listed)
        Add(kind, nb::cast<nb::tuple>(log), initial_soc, campaign, logs);
    }
  }
};

std::shared_ptr<PythonCampaign> Make(const nb::dict& given, std::vector<std::string> sha256) {
  CampaignKeywords made;
  Keywords keywords(given);
  made.Declare(keywords);
  keywords.Finish();
  return std::make_shared<PythonCampaign>(
      std::move(made.campaign), std::move(made.logs), "", std::move(sha256));
}

nb::list DescribeCampaign() {
  CampaignKeywords made;
  Keywords keywords;
  made.Declare(keywords);
  return keywords.Described();
}

nb::list Entries(const PythonCampaign& self) {
  nb::list entries;
  for (const CampaignLog& log : self.campaign().logs) {
    nb::dict entry;
    entry["kind"] = options_internal::ToText(log.kind);
    entry["file"] = log.file;
    entry["initial_soc"] = log.initial_soc;
    entry["weight"] = log.weight;
    entry["ambient_degC"] = log.ambient_degC;
    entry["initial_degC"] = log.initial_degC;
    entries.append(entry);
  }
  return entries;
}

// A campaign file names files.
std::string ToToml(const PythonCampaign& self) {
  for (std::size_t k = 0; k < self.given().size(); ++k) {
    const std::string& file = self.campaign().logs[k].file;
    if (!self.given()[k] && self.campaign().logs[k].read.most_rows != kMostRowsKept) {
      throw OptionError(fmt::format(
          "to_toml: a campaign file cannot hold most_rows, as the log '{}' has it; leave it out there, or keep "
          "the campaign in Python",
          file));
    }
    if (!self.given()[k] || std::filesystem::exists(file)) continue;
    throw OptionError(fmt::format(
        "to_toml: the log '{}' is in memory, and a campaign file names files; write it to one "
        "(log.to_pandas().to_csv(file, index=False)) and make the campaign of the file",
        file));
  }
  return CampaignToToml(self.campaign());
}

// The logs as identification sees them: those of one cell.
nb::list Logs(const PythonCampaign& self) {
  const std::vector<LoadedLog>* logs = nullptr;
  {
    const WithoutLock unlocked;
    logs = &self.Logs();
  }
  nb::list list;
  for (const LoadedLog& log : *logs) {
    // A copy of what was read; what was lent stays lent.
    PythonLog one{std::make_shared<const Log>(log.log)};
    list.append(
        nb::make_tuple(options_internal::ToText(log.entry.kind), one, log.entry.initial_soc));
  }
  return list;
}

}  // namespace

PythonCampaign::PythonCampaign(Campaign campaign,
                               std::vector<std::optional<PythonLog>> given,
                               std::string text,
                               std::vector<std::string> sha256)
    : campaign_(std::move(campaign)),
      text_(std::move(text)),
      earlier_(std::move(sha256)),
      given_(std::move(given)) {
  given_.resize(campaign_.logs.size());
}

std::vector<std::string> PythonCampaign::Inputs() const {
  std::vector<std::string> files;
  if (!campaign_.file.empty()) files.push_back(campaign_.file);
  for (std::size_t k = 0; k < given_.size(); ++k) {
    const CampaignLog& entry = campaign_.logs[k];
    files.push_back(given_[k] ? entry.file : entry.path);
  }
  return files;
}

std::vector<std::string> PythonCampaign::Sums() const {
  const std::lock_guard lock(mutex_);
  return logs_ ? sha256_ : earlier_;
}

const std::vector<LoadedLog>& PythonCampaign::Logs() const {
  const std::lock_guard lock(mutex_);
  if (logs_) return *logs_;
  std::vector<std::size_t> in_files;
  std::vector<std::size_t> in_memory;
  std::vector<Log> lent;
  for (std::size_t k = 0; k < given_.size(); ++k) {
    (given_[k] ? in_memory : in_files).push_back(k);
    if (given_[k]) lent.push_back(given_[k]->Lent());
  }
  std::vector<LoadedLog> logs(given_.size());
  const auto put = [&](const std::vector<std::size_t>& places, std::vector<LoadedLog> some) {
    for (std::size_t k = 0; k < places.size(); ++k) logs[places[k]] = std::move(some[k]);
  };
  if (!in_files.empty()) put(in_files, LoadCampaign(Part(campaign_, in_files)));
  if (!in_memory.empty()) put(in_memory, TakeLogs(Part(campaign_, in_memory), std::move(lent)));
  AddSums();
  logs_ = std::move(logs);
  return *logs_;
}

// At once, as a file may be another one when a cell is made of what was read.
void PythonCampaign::AddSums() const {
  std::vector<std::string> files;
  std::vector<std::string> sha256;
  const auto add = [&](const std::string& file, std::string sum) {
    if (files.size() < earlier_.size() && earlier_[files.size()] != sum) {
      throw LoadError({file},
                      "expected the file as it was when it was first read, found another SHA-256; "
                      "put that file back, or identify again");
    }
    files.push_back(file);
    sha256.push_back(std::move(sum));
  };
  if (!campaign_.file.empty()) add(campaign_.file, Sha256OfBytes(text_));
  for (std::size_t k = 0; k < given_.size(); ++k) {
    const CampaignLog& entry = campaign_.logs[k];
    const std::string& name = given_[k] ? entry.file : entry.path;
    if (!given_[k] && std::find(files.begin(), files.end(), name) != files.end()) continue;
    add(name, given_[k] ? SumOf(given_[k]->log->record) : Sha256OfFile(name));
  }
  files_ = std::move(files);
  sha256_ = std::move(sha256);
}

void PythonCampaign::AddInputsTo(RunRecord& run) const {
  (void)Logs();
  run.inputs = files_;
  run.sha256 = sha256_;
}

void AddCampaigns(nb::module_& module) {
  nb::class_<PythonCampaign>(module, "Campaign")
      .def_prop_ro("file", [](const PythonCampaign& self) { return self.campaign().file; })
      .def_prop_ro("name", [](const PythonCampaign& self) { return self.campaign().name; })
      .def_prop_ro("capacity_Ah",
                   [](const PythonCampaign& self) -> std::optional<double> {
                     const double capacity_Ah = self.campaign().capacity_Ah;
                     return capacity_Ah > 0.0 ? std::optional(capacity_Ah) : std::nullopt;
                   })
      .def_prop_ro("cutoff_V", [](const PythonCampaign& self) { return self.campaign().cutoff_V; })
      .def_prop_ro("series", [](const PythonCampaign& self) { return self.campaign().series; })
      .def_prop_ro("parallel", [](const PythonCampaign& self) { return self.campaign().parallel; })
      .def_prop_ro("inputs", [](const PythonCampaign& self) { return ToPython(self.Inputs()); })
      .def_prop_ro("text", &PythonCampaign::text)
      .def_prop_ro("sha256", &PythonCampaign::Sums)
      .def("entries", &Entries)
      .def("logs", &Logs)
      .def("to_toml", &ToToml);
  module.def(
      "parse_campaign",
      [](std::string text, nb::handle file, std::vector<std::string> sha256) {
        Campaign campaign = ParseCampaign(text, PathOf(file));
        return std::make_shared<PythonCampaign>(std::move(campaign),
                                                std::vector<std::optional<PythonLog>>{},
                                                std::move(text),
                                                std::move(sha256));
      },
      nb::arg("text"),
      nb::arg("file"),
      nb::arg("sha256"));
  module.def(
      "read_campaign",
      [](nb::handle file) {
        const std::string path = PathOf(file);
        std::string text = ReadTextFile(path);
        Campaign campaign = ParseCampaign(text, path);
        return std::make_shared<PythonCampaign>(std::move(campaign),
                                                std::vector<std::optional<PythonLog>>{},
                                                std::move(text),
                                                std::vector<std::string>{});
      },
      nb::arg("file"));
  module.def("make_campaign", &Make, nb::arg("options"), nb::arg("sha256"));
  module.def("describe_campaign", &DescribeCampaign);
}

}  // namespace lipoid::python
