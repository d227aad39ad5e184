#pragma once

/// @file
/// What lies on the table of a session: the logs that were dropped and what `lipoid inspect` says of
/// each, the campaign that they make with what a person changed of it, and the jobs. All that the page
/// shows is here, so that a reload or a second tab shows the same. From any thread. Tests:
/// tests/tools/serve/workbench_test.cc, tests/tools/serve_test.py.

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "identify/logs/campaign.h"
#include "model/core/json.h"
#include "tools/serve/http_server.h"
#include "tools/serve/job_queue.h"
#include "tools/serve/job_request.h"
#include "tools/serve/settings.h"

namespace lipoid {

struct WorkbenchLimits {
  int jobs = 1;                 ///< at once
  std::size_t kept_jobs = 100;  ///< that wait, run or are done
  std::size_t files = 200;
  std::uint64_t file_bytes = 0;   ///< of one upload
  std::uint64_t total_bytes = 0;  ///< of all of them
};

class Workbench {
 public:
  /// `folder` is there, empty and its own.
  Workbench(std::string folder,
            std::string program,
            const WorkbenchLimits& limits,
            const JobOptions& options);
  ~Workbench();
  Workbench(const Workbench&) = delete;
  Workbench& operator=(const Workbench&) = delete;

  /// Takes a log of this name; its answer says {"id": ...}. HttpError where it is too large, or there
  /// are too many, or the disk has no room.
  [[nodiscard]] std::unique_ptr<BodySink> Upload(std::string_view name,
                                                 std::optional<std::uint64_t> bytes);
  void RemoveFile(int id);

  /// What a person changes: {"cell": {"name": ..., "capacity_Ah": ..., "cutoff_V": ..., "series": ...,
  /// "parallel": ...}, "reading": {"columns": ..., "units": ..., "current_sign": ..., "hold": ..., "battery": ...},
  /// "tests": {"3": {"kind": "pulses", "initial_soc": 0.9, "ambient_degC": 5}}}; each key may be missing, and
  /// null is as lipoid finds it. HttpError where any of it is wrong; then nothing is changed.
  void Change(const Json& change);

  /// Starts what JobOptions reads; its number.
  int Start(const Json& asked);
  void CancelJob(int id) { jobs_->Cancel(id); }
  void RemoveJob(int id) { jobs_->Remove(id); }
  [[nodiscard]] std::string Output(int job, std::string_view name) const {
    return jobs_->Output(job, name);
  }

  /// The campaign as it is now, as TOML.
  [[nodiscard]] std::string CampaignText() const;

  /// All of it for the page; `version()` rises with every change of it.
  [[nodiscard]] Json State() const;
  [[nodiscard]] std::uint64_t version() const { return version_; }
  [[nodiscard]] bool IsBusy() const;
  [[nodiscard]] int files_taken() const;
  [[nodiscard]] int jobs_taken() const { return jobs_->added(); }

 private:
  class FileSink;
  struct File {
    std::string given;  // the name that it had
    std::string name;   // under which it is kept, and which lipoid says
    std::uint64_t bytes = 0;
    Json inspection;    // an entry of files[] of `inspect --summary`; null: not yet
    std::string error;  // why there is none
  };
  // A test within a file: a row of the campaign.
  struct Row {
    std::string key;  // "3", or "3.1" where a file holds several
    int file = 0;
    std::optional<LogKind> kind;  // as suggested
    CampaignLog log;
    std::string reason;
    std::vector<std::string> remarks;
    std::string left_out;
  };
  void Changed() { ++version_; }
  /// HttpError where an upload of so many bytes is too large, by itself or with the others.
  void CheckSize(std::uint64_t bytes) const;
  [[nodiscard]] std::string FilesFolder() const { return folder_ + "/files"; }
  int Keep(const std::string& temporary, const std::string& given, std::uint64_t bytes);
  void InspectAgain();
  void Inspect(const std::stop_token& stop);
  void TakeInspection(const std::vector<int>& ids, const Json& summary, const std::string& message);
  void MakeRows(const Json& draft);
  [[nodiscard]] std::vector<std::string> InspectArguments(const std::vector<int>& ids) const;
  [[nodiscard]] std::optional<LogKind> KindOf(const Row& row) const;
  [[nodiscard]] RowSettings Said(const Row& row) const;
  [[nodiscard]] Campaign CampaignNow() const;
  /// What the page says of these files as options of `lipoid validate`, but for those in `given`: that command takes one
  /// value for all of its logs. HttpError where they differ.
  [[nodiscard]] std::vector<std::string> ValidateArguments(
      const std::vector<int>& ids, const std::vector<std::string>& given) const;
  void LinkLogs(const std::vector<int>& ids, const std::string& folder) const;

  std::string folder_;
  std::string program_;
  WorkbenchLimits limits_;
  const JobOptions& options_;
  std::atomic<std::uint64_t> version_ = 1;

  mutable std::mutex mutex_;
  std::map<int, File> files_;
  int last_file_ = 0;
  int last_upload_ = 0;
  int uploads_ = 0;                 // that are coming in
  std::uint64_t coming_bytes_ = 0;  // of these
  CellSettings cell_;
  ReadingSettings reading_;
  std::map<std::string, RowSettings> said_;  // by key
  Json drafted_ = Json::object();            // what inspect drafts of the cell
  std::vector<Row> rows_;

  bool inspect_again_ = false;
  bool inspecting_ = false;
  std::stop_source inspection_;
  std::condition_variable_any wake_;
  std::unique_ptr<JobQueue> jobs_;
  std::jthread inspector_;  // last: it ends before the rest
};

}  // namespace lipoid
