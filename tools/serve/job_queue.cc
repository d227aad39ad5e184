#include "tools/serve/job_queue.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <exception>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <system_error>

#include "tools/serve/http_server.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostBytesOfText = 64 << 10;

double Now_s() {
  return std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
}

std::string_view Name(JobStatus status) {
  switch (status) {
    case JobStatus::kQueued:
      return "queued";
    case JobStatus::kRunning:
      return "running";
    case JobStatus::kDone:
      return "done";
    case JobStatus::kFailed:
      return "failed";
    case JobStatus::kCancelled:
      break;
  }
  return "cancelled";
}

bool Waits(JobStatus status) {
  return status == JobStatus::kQueued || status == JobStatus::kRunning;
}

// Logs that a job read need not be kept twice; nor what one that was stopped left half-written.
void KeepOutputsAlone(const std::string& folder) {
  std::error_code ignored;
  std::vector<fs::path> others;
  for (fs::directory_iterator each(folder, ignored), end; !ignored && each != end;
       each.increment(ignored)) {
    const auto name = each->path().filename().string();
    if (std::find(OutputNames().begin(), OutputNames().end(), name) == OutputNames().end())
      others.push_back(each->path());
  }
  for (const fs::path& other : others) fs::remove_all(other, ignored);
}

// The beginning of a text file, or "".
std::string Beginning(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  std::string text(kMostBytesOfText, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(std::max<std::streamsize>(stream.gcount(), 0)));
  return text;
}

// The lines before the first empty one, as one.
std::string FirstParagraph(const std::string& text) {
  std::string paragraph = text.substr(0, text.find("\n\n"));
  std::replace(paragraph.begin(), paragraph.end(), '\n', ' ');
  return paragraph;
}

}  // namespace

const std::vector<std::string>& OutputNames() {
  static const std::vector<std::string> kNames = {"report.html",
                                                  "cell.json",
                                                  "campaign.toml",
                                                  "flight.csv",
                                                  "summary.json",
                                                  "output.txt",
                                                  "messages.txt"};
  return kNames;
}

JobQueue::JobQueue(std::string folder,
                   std::string program,
                   int at_once,
                   std::size_t kept,
                   std::function<void()> changed)
    : folder_(std::move(folder)),
      program_(std::move(program)),
      kept_(kept),
      changed_(std::move(changed)) {
  for (int k = 0; k < at_once; ++k)
    workers_.emplace_back([this](const std::stop_token& stop) { Work(stop); });
}

JobQueue::~JobQueue() {
  {
    const std::lock_guard lock(mutex_);
    queue_.clear();
    for (auto& [id, job] : jobs_) job.stop.request_stop();
  }
  for (std::jthread& worker : workers_) worker.request_stop();
}

int JobQueue::Add(JobPlan plan) {
  int id = 0;
  {
    const std::lock_guard lock(mutex_);
    if (jobs_.size() >= kept_) {
      throw HttpError(409, fmt::format("there are {} jobs already; remove some", jobs_.size()));
    }
    id = ++last_;
  }
  std::error_code trouble;
  fs::create_directory(FolderOf(id), trouble);
  if (trouble)
    throw HttpError(507, fmt::format("cannot make a folder for the job: {}", trouble.message()));
  try {
    plan.prepare(FolderOf(id));
  } catch (...) {
    fs::remove_all(FolderOf(id), trouble);
    throw;
  }
  {
    const std::lock_guard lock(mutex_);
    Job& job = jobs_[id];
    job.plan = std::move(plan);
    job.added_s = Now_s();
    queue_.push_back(id);
  }
  waiting_.notify_one();
  changed_();
  return id;
}

void JobQueue::Cancel(int id) {
  {
    const std::lock_guard lock(mutex_);
    const auto found = jobs_.find(id);
    if (found == jobs_.end()) throw HttpError(404, fmt::format("there is no job {}", id));
    Job& job = found->second;
    if (!Waits(job.status)) return;
    job.stop.request_stop();
    if (job.status == JobStatus::kQueued) {
      job.status = JobStatus::kCancelled;
      job.ended_s = Now_s();
      queue_.erase(std::remove(queue_.begin(), queue_.end(), id), queue_.end());
    }
  }
  changed_();
}

void JobQueue::Remove(int id) {
  {
    const std::lock_guard lock(mutex_);
    if (Waits(Find(id).status))
      throw HttpError(409, fmt::format("job {} waits or runs; cancel it first", id));
    jobs_.erase(id);
  }
  std::error_code ignored;
  fs::remove_all(FolderOf(id), ignored);
  changed_();
}

Json JobQueue::ToJson() const {
  const std::lock_guard lock(mutex_);
  Json all = Json::array();
  for (const auto& [id, job] : jobs_) {
    Json json = {{"id", id}, {"status", Name(job.status)}};
    json.update(job.plan.about);
    json["added_s"] = job.added_s;
    if (job.began_s > 0.0) json["began_s"] = job.began_s;
    if (job.ended_s > 0.0) json["ended_s"] = job.ended_s;
    if (job.status == JobStatus::kRunning) {
      json["fraction"] = job.fraction;
      json["doing"] = job.doing;
    }
    if (!Waits(job.status)) {
      json["exit_code"] = job.end.exit_code;
      json["message"] = job.message;
      if (!job.verdict.empty()) json["verdict"] = job.verdict;
      json["outputs"] = Json::array();
      for (const std::string& name : OutputNames()) {
        std::error_code none;
        const auto bytes = fs::file_size(FolderOf(id) + "/" + name, none);
        if (!none && bytes > 0) json["outputs"].push_back({{"name", name}, {"bytes", bytes}});
      }
    }
    all.push_back(std::move(json));
  }
  return all;
}

bool JobQueue::IsBusy() const {
  const std::lock_guard lock(mutex_);
  return std::any_of(
      jobs_.begin(), jobs_.end(), [](const auto& each) { return Waits(each.second.status); });
}

int JobQueue::added() const {
  const std::lock_guard lock(mutex_);
  return last_;
}

std::optional<int> JobQueue::ReaderOf(int file) const {
  const std::lock_guard lock(mutex_);
  for (const auto& [id, job] : jobs_) {
    const auto& files = job.plan.files;
    if (Waits(job.status) && std::find(files.begin(), files.end(), file) != files.end()) return id;
  }
  return std::nullopt;
}

std::string JobQueue::Output(int id, std::string_view name) const {
  const std::lock_guard lock(mutex_);
  const bool known =
      std::find(OutputNames().begin(), OutputNames().end(), name) != OutputNames().end();
  std::error_code none;
  std::string path = FolderOf(id) + "/" + std::string(name);
  if (Waits(Find(id).status) || !known || !fs::is_regular_file(path, none))
    throw HttpError(404, fmt::format("job {} has no file of this name", id));
  return path;
}

std::string JobQueue::FolderOf(int id) const { return fmt::format("{}/{}", folder_, id); }

const JobQueue::Job& JobQueue::Find(int id) const {
  const auto found = jobs_.find(id);
  if (found == jobs_.end()) throw HttpError(404, fmt::format("there is no job {}", id));
  return found->second;
}

void JobQueue::Work(const std::stop_token& stop) {
  while (!stop.stop_requested()) {
    int id = 0;
    {
      std::unique_lock lock(mutex_);
      if (!waiting_.wait(lock, stop, [this] { return !queue_.empty(); })) return;
      id = queue_.front();
      queue_.pop_front();
      Job& job = jobs_.at(id);
      job.status = JobStatus::kRunning;
      job.began_s = Now_s();
    }
    changed_();
    Run(id);
    changed_();
  }
}

void JobQueue::Run(int id) {
  const std::string folder = FolderOf(id);
  ChildPlan child{.program = program_,
                  .arguments = {},
                  .folder = folder,
                  .output_file = folder + "/output.txt",
                  .message_file = folder + "/messages.txt"};
  std::stop_token stop;
  {
    const std::lock_guard lock(mutex_);
    child.arguments = jobs_.at(id).plan.arguments;
    stop = jobs_.at(id).stop.get_token();
  }
  ChildEnd end;
  std::string message;
  try {
    end = RunChild(child, stop, [&](double fraction, std::string_view doing) {
      {
        const std::lock_guard lock(mutex_);
        jobs_.at(id).fraction = fraction;
        jobs_.at(id).doing = doing;
      }
      changed_();
    });
    message = Beginning(child.message_file);
  } catch (const std::exception& error) {
    message = fmt::format("the job could not be run: {}", error.what());
  }
  KeepOutputsAlone(folder);
  if (end.signal != 0 && !end.stopped) {
    message +=
        fmt::format("the program was ended by signal {}{}; the other jobs and the server go on\n",
                    end.signal,
                    end.signal == SIGKILL ? ", perhaps for lack of memory" : "");
  }
  const std::lock_guard lock(mutex_);
  Job& job = jobs_.at(id);
  job.end = end;
  job.message = std::move(message);
  job.ended_s = Now_s();
  const bool done = end.exit_code == 0 || end.exit_code == 1;
  job.status = done ? JobStatus::kDone : end.stopped ? JobStatus::kCancelled : JobStatus::kFailed;
  if (done && job.plan.about.value("command", "") != "fly")
    job.verdict = FirstParagraph(Beginning(child.output_file));
}

}  // namespace lipoid
