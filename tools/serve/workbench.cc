#include "tools/serve/workbench.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "model/core/errors.h"
#include "tools/serve/child.h"
#include "tools/serve/safe_name.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kSummary = "inspect.json";
// What results need beside the logs.
constexpr std::uint64_t kSpareBytes = 64 << 20;
constexpr std::size_t kMostBytesOfReason = 8000;

template <class E>
std::string_view NameOf(E value) {
  for (const auto& [candidate, name] : OptionNames(E{})) {
    if (candidate == value) return name;
  }
  return "?";
}

[[noreturn]] void DiskFull() {
  throw HttpError(507,
                  "the disk of the temporary folder has no room for this file; free some, or start "
                  "lipoid serve with TMPDIR set to a folder on a larger disk");
}

std::string Megabytes(std::uint64_t bytes) { return fmt::format("{} MB", bytes / 1'000'000); }

// What the page shows of files[] of the summary: segments are counted, not listed.
Json Shortened(Json inspection) {
  if (inspection.contains("segments")) {
    Json counts = Json::object();
    for (const Json& segment : inspection["segments"]) {
      const auto kind = segment.at("kind").get<std::string>();
      counts[kind] = counts.value(kind, 0) + 1;
    }
    inspection.erase("segments");
    inspection["segments_of_kind"] = std::move(counts);
  }
  if (inspection.contains("gaps")) {
    const std::size_t gaps = inspection["gaps"].size();
    inspection.erase("gaps");
    inspection["gaps"] = gaps;
  }
  return inspection;
}

// What a command that failed says of one file, as it would print it.
std::string MessageOn(const Json& error, const std::string& file) {
  std::vector<Diagnostic> diagnostics;
  for (const Json& each : error.value("diagnostics", Json::array())) {
    if (each.value("file", "") != file) continue;
    diagnostics.push_back(
        {{file, each.value("line", std::size_t{1}), each.value("column", std::size_t{1})},
         each.value("message", "")});
  }
  if (diagnostics.empty()) return error.value("message", "");
  return LoadError(std::move(diagnostics)).what();
}

// At once: what is written by AtomicFile waits until the command is done, which here is the server.
void WriteText(const std::string& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary);
  stream << text;
  stream.close();
  if (!stream) DiskFull();
}

}  // namespace

// Bytes of an upload on their way to the disk, under a number.
class Workbench::FileSink : public BodySink {
 public:
  FileSink(Workbench& bench, std::string given, int number)
      : bench_(bench),
        given_(std::move(given)),
        path_(fmt::format("{}/incoming/{}", bench.folder_, number)) {
    descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (descriptor_ < 0)
      throw HttpError(507, fmt::format("cannot keep the file: {}", std::strerror(errno)));
    const std::lock_guard lock(bench_.mutex_);
    ++bench_.uploads_;
  }
  ~FileSink() override {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!path_.empty()) ::unlink(path_.c_str());
    const std::lock_guard lock(bench_.mutex_);
    --bench_.uploads_;
    bench_.coming_bytes_ -= bytes_;
    bench_.wake_.notify_all();
  }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  void Write(std::string_view bytes) override {
    {
      const std::lock_guard lock(bench_.mutex_);
      bytes_ += bytes.size();
      bench_.coming_bytes_ += bytes.size();
    }
    bench_.CheckSize(bytes_);
    while (!bytes.empty()) {
      const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
      if (written < 0 && errno == EINTR) continue;
      if (written < 0 && (errno == ENOSPC || errno == EDQUOT || errno == EFBIG)) DiskFull();
      if (written < 0)
        throw HttpError(507, fmt::format("cannot keep the file: {}", std::strerror(errno)));
      bytes.remove_prefix(static_cast<std::size_t>(written));
    }
  }

  HttpResponse Finish() override {
    if (::close(std::exchange(descriptor_, -1)) != 0) DiskFull();
    const int id = bench_.Keep(path_, given_, bytes_);
    path_.clear();
    return {.status = 201,
            .type = "application/json",
            .body = Json({{"id", id}}).dump(),
            .file = "",
            .headers = {}};
  }

 private:
  Workbench& bench_;
  std::string given_;
  std::string path_;
  int descriptor_ = -1;
  std::uint64_t bytes_ = 0;
};

Workbench::Workbench(std::string folder,
                     std::string program,
                     const WorkbenchLimits& limits,
                     const JobOptions& options)
    : folder_(std::move(folder)), program_(std::move(program)), limits_(limits), options_(options) {
  for (const char* const part : {"/files", "/incoming", "/jobs"})
    fs::create_directory(folder_ + part);
  jobs_ = std::make_unique<JobQueue>(
      folder_ + "/jobs", program_, limits.jobs, limits.kept_jobs, [this] { Changed(); });
  inspector_ = std::jthread([this](const std::stop_token& stop) { Inspect(stop); });
}

Workbench::~Workbench() {
  const std::lock_guard lock(mutex_);
  inspector_.request_stop();
  inspection_.request_stop();
}

void Workbench::CheckSize(std::uint64_t bytes) const {
  if (bytes > limits_.file_bytes) {
    throw HttpError(413,
                    fmt::format("a file may have {}; start lipoid serve with a larger "
                                "--max-file-MB",
                                Megabytes(limits_.file_bytes)));
  }
  const std::lock_guard lock(mutex_);
  std::uint64_t kept = 0;
  for (const auto& [id, file] : files_) kept += file.bytes;
  if (kept + std::max(bytes, coming_bytes_) > limits_.total_bytes) {
    throw HttpError(
        413,
        fmt::format("all files together may have {}; remove some, or start lipoid serve "
                    "with a larger --max-total-MB",
                    Megabytes(limits_.total_bytes)));
  }
}

std::unique_ptr<BodySink> Workbench::Upload(std::string_view name,
                                            std::optional<std::uint64_t> bytes) {
  if (name.empty() || name.size() > 1000)
    throw HttpError(400, "a file has a name of at most 1000 bytes");
  CheckSize(bytes.value_or(0));
  std::error_code none;
  const auto space = fs::space(folder_, none);
  if (!none && space.available < bytes.value_or(0) + kSpareBytes) DiskFull();
  int number = 0;
  {
    const std::lock_guard lock(mutex_);
    if (files_.size() + static_cast<std::size_t>(uploads_) >= limits_.files)
      throw HttpError(409, fmt::format("there may be {} files; remove some", limits_.files));
    number = ++last_upload_;
  }
  return std::make_unique<FileSink>(*this, std::string(name), number);
}

int Workbench::Keep(const std::string& temporary, const std::string& given, std::uint64_t bytes) {
  int id = 0;
  {
    const std::lock_guard lock(mutex_);
    // Logs stand beside the results of a job.
    std::set<std::string> taken(OutputNames().begin(), OutputNames().end());
    for (const auto& [other, file] : files_) taken.insert(file.name);
    const std::string name = SafeName(given, taken);
    fs::rename(temporary, FilesFolder() + "/" + name);
    id = ++last_file_;
    File& file = files_[id];
    file.given = given;
    file.name = name;
    file.bytes = bytes;
    inspect_again_ = true;
  }
  wake_.notify_all();
  Changed();
  return id;
}

void Workbench::RemoveFile(int id) {
  if (const auto job = jobs_->ReaderOf(id)) {
    throw HttpError(
        409, fmt::format("job {} reads this file; cancel it, or wait until it is done", *job));
  }
  {
    const std::lock_guard lock(mutex_);
    const auto found = files_.find(id);
    if (found == files_.end()) throw HttpError(404, fmt::format("there is no file {}", id));
    std::error_code ignored;
    fs::remove(FilesFolder() + "/" + found->second.name, ignored);
    files_.erase(found);
    std::erase_if(rows_, [&](const Row& row) { return row.file == id; });
    std::erase_if(said_, [&](const auto& each) {
      return each.first == fmt::format("{}", id) || each.first.starts_with(fmt::format("{}.", id));
    });
    InspectAgain();
  }
  wake_.notify_all();
  Changed();
}

// The locked part of starting over.
void Workbench::InspectAgain() {
  inspect_again_ = true;
  inspection_.request_stop();
}

void Workbench::Change(const Json& change) {
  OnlyKeys(change, {"cell", "reading", "tests"});
  {
    const std::lock_guard lock(mutex_);
    CellSettings cell = cell_;
    ReadingSettings reading = reading_;
    auto said = said_;
    if (change.contains("cell")) cell.Change(change["cell"]);
    if (change.contains("reading")) reading.Change(change["reading"]);
    if (change.contains("tests")) {
      if (!change["tests"].is_object()) throw HttpError(400, "tests: expected an object");
      for (const auto& [key, value] : change["tests"].items()) {
        const bool known = std::any_of(
            rows_.begin(), rows_.end(), [&, k = key](const Row& row) { return row.key == k; });
        if (!known) throw HttpError(404, "tests: there is no such log");
        said[key].Change(value);
      }
    }
    // All of it is right; from here on nothing is refused. The draft divides by the pack.
    const bool other_draft = cell.DraftArguments() != cell_.DraftArguments();
    if (other_draft || change.contains("reading")) InspectAgain();
    cell_ = std::move(cell);
    reading_ = std::move(reading);
    said_ = std::move(said);
  }
  wake_.notify_all();
  Changed();
}

std::vector<std::string> Workbench::InspectArguments(const std::vector<int>& ids) const {
  std::vector<std::string> arguments = {"inspect"};
  for (const int id : ids) arguments.push_back(files_.at(id).name);
  arguments.push_back(fmt::format("--summary=../{}", kSummary));
  for (std::string& argument : cell_.DraftArguments()) arguments.push_back(std::move(argument));
  for (std::string& argument : reading_.Arguments()) arguments.push_back(std::move(argument));
  return arguments;
}

void Workbench::Inspect(const std::stop_token& stop) {
  struct Outcome {
    bool ended = false;  // by itself, with an answer
    bool stopped = false;
    Json summary = Json::object();
    std::string message;
  };
  const auto run = [this](const std::vector<std::string>& arguments,
                          const std::stop_token& stop_this) {
    const std::string summary = fmt::format("{}/{}", folder_, kSummary);
    std::error_code ignored;
    fs::remove(summary, ignored);
    const ChildPlan child{.program = program_,
                          .arguments = arguments,
                          .folder = FilesFolder(),
                          .output_file = folder_ + "/inspect.out",
                          .message_file = folder_ + "/inspect.err"};
    Outcome outcome;
    try {
      const ChildEnd end = RunChild(child, stop_this, [](double, std::string_view) {});
      outcome.stopped = end.stopped;
      if (end.signal != 0)
        outcome.message = fmt::format("reading this file ended lipoid by signal {}", end.signal);
      if (end.exit_code >= 0 && end.exit_code < 4) {
        outcome.summary = ParseJson(ReadTextFile(summary), std::string(kSummary));
        outcome.ended = true;
      } else if (end.exit_code >= 4) {
        outcome.message = ReadTextFile(child.message_file);
      }
    } catch (const std::exception& error) {
      outcome.message = error.what();
    }
    if (outcome.message.size() > kMostBytesOfReason) outcome.message.resize(kMostBytesOfReason);
    return outcome;
  };

  while (true) {
    std::vector<int> ids;
    std::stop_token stop_this;
    {
      std::unique_lock lock(mutex_);
      inspecting_ = false;
      Changed();
      // Files that come together are looked at together.
      const bool files_wait =
          wake_.wait(lock, stop, [this] { return inspect_again_ && uploads_ == 0; });
      // Files may wait and the server end: what is begun here would be stopped by nobody.
      if (!files_wait || stop.stop_requested()) return;
      inspect_again_ = false;
      for (const auto& [id, file] : files_) ids.push_back(id);
      if (ids.empty()) {
        drafted_ = Json::object();
        rows_.clear();
        continue;
      }
      inspecting_ = true;
      inspection_ = std::stop_source();
      stop_this = inspection_.get_token();
    }
    Changed();
    const auto arguments_of = [&](const std::vector<int>& of) {
      const std::lock_guard lock(mutex_);
      std::vector<int> there;
      for (const int id : of) {
        if (files_.count(id) > 0) there.push_back(id);
      }
      return InspectArguments(there);
    };
    Outcome outcome = run(arguments_of(ids), stop_this);
    if (!outcome.ended && !stop_this.stop_requested()) {
      // A file that ends the program is told apart from the others.
      std::vector<int> good;
      for (const int id : ids) {
        const Outcome alone = run(arguments_of({id}), stop_this);
        if (stop_this.stop_requested()) break;  // it says nothing of the file
        if (alone.ended) {
          good.push_back(id);
          continue;
        }
        const std::lock_guard lock(mutex_);
        if (const auto file = files_.find(id); file != files_.end()) {
          file->second.inspection = nullptr;
          file->second.error = alone.message;
        }
      }
      ids = std::move(good);
      if (!ids.empty() && !stop_this.stop_requested()) outcome = run(arguments_of(ids), stop_this);
    }
    if (stop_this.stop_requested()) continue;
    const std::lock_guard lock(mutex_);
    try {
      TakeInspection(ids, outcome.summary, outcome.message);
    } catch (const Json::exception& error) {  // it is lipoid that wrote it
      for (auto& [id, file] : files_)
        file.error =
            fmt::format("the answer of lipoid inspect is not as expected: {}", error.what());
    }
  }
}

void Workbench::TakeInspection(const std::vector<int>& ids,
                               const Json& summary,
                               const std::string& message) {
  for (const int id : ids) {
    const auto found = files_.find(id);
    if (found == files_.end()) continue;
    File& file = found->second;
    file.inspection = nullptr;
    file.error = message;
    if (summary.contains("error")) {
      file.error = MessageOn(summary["error"], file.name);
      continue;
    }
    for (const Json& each : summary.value("files", Json::array())) {
      if (each.value("file", "") != file.name) continue;
      file.error = each.value("error", "");
      if (file.error.empty()) file.inspection = Shortened(each);
    }
  }
  MakeRows(summary.value("draft", Json::object()));
}

void Workbench::MakeRows(const Json& draft) {
  drafted_ = draft;
  drafted_.erase("logs");
  drafted_.erase("name");  // that of the folder
  rows_.clear();
  for (const auto& [id, file] : files_) {
    if (file.inspection.is_null()) continue;
    const Json& parts = file.inspection.at("parts");
    for (std::size_t k = 0; k < std::max<std::size_t>(parts.size(), 1); ++k) {
      Row row;
      row.key = parts.empty() ? fmt::format("{}", id) : fmt::format("{}.{}", id, k + 1);
      row.file = id;
      row.log.file = file.name;
      row.log.read = reading_.Options();
      if (!parts.empty()) {
        row.log.read.start_s = parts[k].at("start_s").get<double>();
        row.log.read.end_s = parts[k].at("end_s").get<double>();
      } else {
        row.reason = file.inspection.value("suggested_kind_reason", "");
      }
      if (file.inspection.value("current_sign_is_of_others", false))
        row.log.read.current_sign = file.inspection.value("current_sign", "");
      for (const Json& entry : draft.value("logs", Json::array())) {
        const bool same_start =
            parts.empty() || entry.value("start_s", 0.0) == row.log.read.start_s;
        if (entry.value("file", "") != file.name || !same_start) continue;
        row.kind = KindNamed(entry.value("kind", ""));
        row.log.initial_soc = entry.value("initial_soc", 1.0);
        row.reason = entry.value("reason", "");
        row.remarks = entry.value("remarks", std::vector<std::string>());
        if (entry.contains("left_out") && entry["left_out"].is_string())
          row.left_out = entry["left_out"].get<std::string>();
      }
      rows_.push_back(std::move(row));
    }
  }
}

std::optional<LogKind> Workbench::KindOf(const Row& row) const {
  const RowSettings said = Said(row);
  if (said.left_out || said.kind) return said.kind;
  return row.left_out.empty() ? row.kind : std::nullopt;
}

RowSettings Workbench::Said(const Row& row) const {
  const auto said = said_.find(row.key);
  return said == said_.end() ? RowSettings() : said->second;
}

Campaign Workbench::CampaignNow() const {
  Campaign campaign;
  campaign.file = "campaign.toml";
  campaign.name = cell_.name.value_or("");
  const auto drafted = [&](const char* key) -> std::optional<double> {
    const auto found = drafted_.find(key);
    return found != drafted_.end() && found->is_number() ? std::optional(found->get<double>())
                                                         : std::nullopt;
  };
  campaign.capacity_Ah =
      cell_.capacity_Ah ? *cell_.capacity_Ah : drafted("capacity_Ah").value_or(0.0);
  campaign.cutoff_V = cell_.cutoff_V ? cell_.cutoff_V : drafted("cutoff_V");
  campaign.series = cell_.series.value_or(static_cast<int>(drafted("series").value_or(1.0)));
  campaign.parallel = cell_.parallel.value_or(static_cast<int>(drafted("parallel").value_or(1.0)));
  for (const Row& row : rows_) {
    const auto kind = KindOf(row);
    if (!kind) continue;
    campaign.logs.push_back(row.log);
    CampaignLog& log = campaign.logs.back();
    const RowSettings said = Said(row);
    log.kind = *kind;
    log.initial_soc = said.initial_soc.value_or(log.initial_soc);
    log.ambient_degC = said.ambient_degC;
  }
  return campaign;
}

std::string Workbench::CampaignText() const {
  const std::lock_guard lock(mutex_);
  return CampaignToToml(CampaignNow());
}

// The disk holds them once, whoever removes them first.
void Workbench::LinkLogs(const std::vector<int>& ids, const std::string& folder) const {
  for (const int id : ids) {
    const std::string& name = files_.at(id).name;
    std::error_code trouble;
    fs::create_hard_link(FilesFolder() + "/" + name, folder + "/" + name, trouble);
    if (trouble) fs::copy_file(FilesFolder() + "/" + name, folder + "/" + name, trouble);
    if (trouble) throw HttpError(507, fmt::format("cannot take the logs: {}", trouble.message()));
  }
}

std::vector<std::string> Workbench::ValidateArguments(const std::vector<int>& ids,
                                                      const std::vector<std::string>& given) const {
  std::vector<std::string> arguments;
  const auto is_given = [&](std::string_view option) {
    return std::any_of(
        given.begin(), given.end(), [&](const auto& each) { return each.starts_with(option); });
  };
  const auto one_for_all = [&](std::string_view option, std::string_view same, const auto& of) {
    std::optional<double> value;
    for (std::size_t k = 0; k < ids.size(); ++k) {
      // Where a file holds several tests, it begins with the first of them.
      const auto row = std::find_if(
          rows_.begin(), rows_.end(), [&](const Row& each) { return each.file == ids[k]; });
      const std::optional<double> said = row == rows_.end() ? std::nullopt : of(*row);
      if (k > 0 && said != value) {
        throw HttpError(
            409,
            fmt::format("these logs do not all {}, and lipoid validate takes one for all of them: "
                        "validate those that do, group by group, or set {}",
                        same,
                        option));
      }
      value = said;
    }
    if (value) arguments.push_back(fmt::format("{}={}", option, *value));
  };
  if (!is_given("--initial-soc") && !is_given("--initial-voltage-V")) {
    one_for_all("--initial-soc", "start at the same state of charge", [&](const Row& row) {
      return std::optional(Said(row).initial_soc.value_or(row.log.initial_soc));
    });
  }
  if (!is_given("--ambient-degC")) {
    one_for_all("--ambient-degC", "have the same temperature of the air", [&](const Row& row) {
      return Said(row).ambient_degC;
    });
  }
  for (std::string& argument : cell_.PackArguments()) {
    if (!is_given(argument.substr(0, argument.find('=')))) arguments.push_back(std::move(argument));
  }
  return arguments;
}

int Workbench::Start(const Json& asked) {
  const JobRequest request = options_.Read(asked);
  const std::string cell_file = request.cell_of ? jobs_->Output(*request.cell_of, "cell.json") : "";
  JobPlan plan;
  plan.arguments = {request.command};
  plan.about = {{"command", request.command}, {"options", request.told}};
  Campaign campaign;
  const std::unique_lock lock(mutex_);
  if (request.command == "identify") {
    campaign = CampaignNow();
    if (campaign.logs.empty()) {
      throw HttpError(409, "no log takes part: drop logs, and mark the kind of each");
    }
    for (const Row& row : rows_) {
      const bool listed =
          std::find(plan.files.begin(), plan.files.end(), row.file) != plan.files.end();
      if (KindOf(row) && !listed) plan.files.push_back(row.file);
    }
    plan.arguments.insert(plan.arguments.end(), {"campaign.toml", "-o", "cell.json"});
    plan.about["name"] = campaign.name;
    plan.about["logs"] = campaign.logs.size();
  } else {
    if (request.command == "fly") {
      plan.arguments.push_back(request.maneuver);
      plan.about["maneuver"] = request.maneuver;
      plan.arguments.insert(
          plan.arguments.end(),
          {"--cell", cell_file.empty() ? request.cell : "cell.json", "-o", "flight.csv"});
    } else {
      plan.arguments.push_back(cell_file.empty() ? request.cell : "cell.json");
      for (const int id : request.logs) {
        if (files_.count(id) == 0) throw HttpError(404, fmt::format("there is no file {}", id));
        if (std::find(plan.files.begin(), plan.files.end(), id) != plan.files.end()) continue;
        plan.files.push_back(id);
        plan.arguments.push_back(files_.at(id).name);
      }
      for (std::string& argument : reading_.Arguments())
        plan.arguments.push_back(std::move(argument));
      for (std::string& argument : ValidateArguments(plan.files, request.options))
        plan.arguments.push_back(std::move(argument));
      plan.about["logs"] = plan.files.size();
    }
    if (request.cell_of) {
      plan.about["cell_of"] = *request.cell_of;
    } else {
      plan.about["cell"] = request.cell;
    }
  }
  plan.arguments.insert(plan.arguments.end(), {"--summary", "summary.json"});
  if (options_.Reports(request.command))
    plan.arguments.insert(plan.arguments.end(), {"--report", "report.html"});
  plan.arguments.insert(plan.arguments.end(), request.options.begin(), request.options.end());
  plan.prepare = [&, files = plan.files](const std::string& folder) {
    LinkLogs(files, folder);
    if (request.command == "identify")
      WriteText(folder + "/campaign.toml", CampaignToToml(campaign));
    if (!cell_file.empty()) fs::copy_file(cell_file, folder + "/cell.json");
  };
  return jobs_->Add(std::move(plan));
}

Json Workbench::State() const {
  const std::uint64_t version = version_;  // what changes from here on is told again
  const std::lock_guard lock(mutex_);
  Json files = Json::array();
  for (const auto& [id, file] : files_) {
    Json json = {{"id", id}, {"name", file.given}, {"kept_as", file.name}, {"bytes", file.bytes}};
    json["status"] = !file.inspection.is_null() ? "read"
                     : file.error.empty()       ? "waiting"
                                                : "refused";
    if (!file.error.empty()) json["error"] = file.error;
    if (!file.inspection.is_null()) json["inspection"] = file.inspection;
    files.push_back(std::move(json));
  }
  Json rows = Json::array();
  for (const Row& row : rows_) {
    const auto kind = KindOf(row);
    const RowSettings said = Said(row);
    Json json = {
        {"key", row.key},
        {"file", row.file},
        {"kind", kind ? Json(NameOf(*kind)) : Json(nullptr)},
        {"suggested", row.kind && row.left_out.empty() ? Json(NameOf(*row.kind)) : Json(nullptr)},
        {"said", said.kind || said.left_out},
        {"initial_soc", NullOr(said.initial_soc)},
        {"found_initial_soc", row.log.initial_soc},
        {"ambient_degC", NullOr(said.ambient_degC)},
        {"reason", row.reason},
        {"remarks", row.remarks},
        {"left_out", row.left_out}};
    if (std::isfinite(row.log.read.start_s)) {
      json["start_s"] = row.log.read.start_s;
      json["end_s"] = row.log.read.end_s;
    }
    rows.push_back(std::move(json));
  }
  Json problem = nullptr;
  try {
    CheckCampaign(CampaignNow(), false);
  } catch (const LoadError& error) {
    problem = Json::array();
    for (const Diagnostic& each : error.diagnostics()) problem.push_back(each.message);
  }
  return {{"version", version},
          {"files", std::move(files)},
          {"inspecting", inspecting_ || inspect_again_},
          {"rows", std::move(rows)},
          {"cell", cell_.ToJson()},
          {"drafted", drafted_},
          {"reading", reading_.ToJson()},
          {"problems", std::move(problem)},
          {"jobs", jobs_->ToJson()}};
}

bool Workbench::IsBusy() const {
  {
    const std::lock_guard lock(mutex_);
    if (inspecting_ || inspect_again_ || uploads_ > 0) return true;
  }
  return jobs_->IsBusy();
}

int Workbench::files_taken() const {
  const std::lock_guard lock(mutex_);
  return last_file_;
}

}  // namespace lipoid
