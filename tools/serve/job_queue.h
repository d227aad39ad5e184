#pragma once

/// @file
/// Runs of lipoid that wait, run and are done: each a process in a folder of its own (child.h), so
/// many at once. Tests: tests/tools/serve_test.py.

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <functional>
#include <map>
#include <mutex>
#include <nlohmann/json.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "model/core/json.h"
#include "tools/serve/child.h"

namespace lipoid {

enum class JobStatus { kQueued, kRunning, kDone, kFailed, kCancelled };

struct JobPlan {
  std::vector<std::string> arguments;  ///< of lipoid, from the command on
  std::vector<int> files;              ///< that it reads, by their numbers: for ReaderOf()
  Json about;                          ///< what is told of the job, as it is: command, title, ...
  /// Fills the folder of the job before it waits.
  std::function<void(const std::string& folder)> prepare;
};

class JobQueue {
 public:
  /// Jobs beyond `kept` are refused until some are removed. `changed` is called, by any thread,
  /// whenever ToJson() says something new; not with the queue locked.
  JobQueue(std::string folder,
           std::string program,
           int at_once,
           std::size_t kept,
           std::function<void()> changed);
  /// Stops all.
  ~JobQueue();
  JobQueue(const JobQueue&) = delete;
  JobQueue& operator=(const JobQueue&) = delete;

  /// Its number. HttpError where there are too many.
  int Add(JobPlan plan);
  /// A job that waits or runs is told to end; HttpError where there is none of this number.
  void Cancel(int id);
  /// Forgets a job that waits and runs no more, and all that it wrote.
  void Remove(int id);

  [[nodiscard]] Json ToJson() const;
  /// Whether one waits or runs.
  [[nodiscard]] bool IsBusy() const;
  /// How many were ever added.
  [[nodiscard]] int added() const;
  /// A job that waits or runs and reads this file.
  [[nodiscard]] std::optional<int> ReaderOf(int file) const;
  /// Where a file of a finished job stands ("cell.json"); HttpError where it wrote none of this name.
  [[nodiscard]] std::string Output(int id, std::string_view name) const;

 private:
  struct Job {
    JobPlan plan;
    JobStatus status = JobStatus::kQueued;
    std::stop_source stop;
    double fraction = 0.0;
    std::string doing;
    double added_s = 0.0;  // since 1970
    double began_s = 0.0;
    double ended_s = 0.0;
    ChildEnd end;
    std::string message;
    std::string verdict;  ///< what identify and validate print first
  };

  [[nodiscard]] std::string FolderOf(int id) const;
  [[nodiscard]] const Job& Find(int id) const;
  void Work(const std::stop_token& stop);
  void Run(int id);

  std::string folder_;
  std::string program_;
  std::size_t kept_;
  std::function<void()> changed_;
  mutable std::mutex mutex_;
  std::condition_variable_any waiting_;
  std::map<int, Job> jobs_;
  std::deque<int> queue_;
  int last_ = 0;
  std::vector<std::jthread> workers_;  // last: they end before the rest
};

/// The files that a job may leave, in the order in which they are shown.
[[nodiscard]] const std::vector<std::string>& OutputNames();

}  // namespace lipoid
