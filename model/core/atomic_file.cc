#include "model/core/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <mutex>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// What has to go if the program ends now, in the order in which it came.
std::mutex uncommitted_mutex;
std::vector<std::string> uncommitted;

void Forget(const std::string& path) {
  const auto found = std::find(uncommitted.begin(), uncommitted.end(), path);
  if (found != uncommitted.end()) uncommitted.erase(found);
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  if (path_ == "/dev/stdout") {
    // By its descriptor: where it leads to a regular file, that file is the shell's and is not
    // replaced.
    const int descriptor = ::dup(STDOUT_FILENO);
    if (descriptor >= 0) file_ = ::fdopen(descriptor, "wb");
    if (file_ == nullptr) Fail(std::strerror(errno));
    return;
  }
  // A link stays a link; what it points to is replaced.
  std::error_code dangling;
  if (const auto target = std::filesystem::canonical(path_, dangling); !dangling)
    path_ = target.string();
  struct stat status {};
  const bool exists = ::stat(path_.c_str(), &status) == 0;
  if (path_.empty() || (exists && S_ISDIR(status.st_mode))) {
    throw OptionError(fmt::format("cannot write '{}': expected the name of a file", path_));
  }
  if (exists && !S_ISREG(status.st_mode)) {
    file_ = std::fopen(path_.c_str(), "wb");
  } else {
    const std::scoped_lock lock(uncommitted_mutex);
    const auto temporary = fmt::format("{}.{}.tmp", path_, ::getpid());
    const int descriptor = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) {
      temporary_ = temporary;
      uncommitted.push_back(temporary_);
      file_ = ::fdopen(descriptor, "wb");
    }
  }
  if (file_ == nullptr) Fail(std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (temporary_.empty()) return;
  const std::scoped_lock lock(uncommitted_mutex);
  ::unlink(temporary_.c_str());
  Forget(temporary_);
}

void AtomicFile::Write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) Fail(std::strerror(errno));
}

void AtomicFile::Commit() {
  const bool flushed =
      std::fflush(file_) == 0 && (temporary_.empty() || ::fsync(::fileno(file_)) == 0);
  const bool closed = std::fclose(file_) == 0;
  file_ = nullptr;
  if (!flushed || !closed) Fail(std::strerror(errno));
  if (temporary_.empty()) return;
  const std::scoped_lock lock(uncommitted_mutex);
  if (std::rename(temporary_.c_str(), path_.c_str()) != 0) Fail(std::strerror(errno));
  Forget(temporary_);
  temporary_.clear();
}

void AtomicFile::Fail(std::string_view what) {
  throw OptionError(fmt::format("cannot write '{}': {}", path_, what));
}

void WriteFileAtomically(const std::string& path, std::string_view bytes) {
  AtomicFile file(path);
  file.Write(bytes);
  file.Commit();
}

NewFolder::NewFolder(const std::string& folder) {
  namespace fs = std::filesystem;
  std::vector<std::string> missing;  // deepest first
  std::error_code error;
  for (auto path = fs::absolute(folder).lexically_normal(); !fs::exists(path, error);
       path = path.parent_path()) {
    if (path.has_filename()) missing.push_back(path.string());
  }
  const std::scoped_lock lock(uncommitted_mutex);
  for (auto path = missing.rbegin(); path != missing.rend() && !error; ++path) {
    if (!fs::create_directory(*path, error)) continue;
    made_.push_back(*path);
    uncommitted.push_back(*path);
  }
  if (!error && !fs::is_directory(folder, error) && !error)
    error = std::make_error_code(std::errc::not_a_directory);
  if (!error) return;
  Unmake();
  throw OptionError(fmt::format("cannot make the folder '{}': {}", folder, error.message()));
}

NewFolder::~NewFolder() {
  const std::scoped_lock lock(uncommitted_mutex);
  Unmake();
}

void NewFolder::Keep() {
  const std::scoped_lock lock(uncommitted_mutex);
  for (const auto& path : made_) Forget(path);
  made_.clear();
}

void NewFolder::Unmake() {
  for (auto path = made_.rbegin(); path != made_.rend(); ++path) {
    ::rmdir(path->c_str());  // fails where someone else put something into it: then it stays
    Forget(*path);
  }
}

void RemoveUncommitted() noexcept {
  uncommitted_mutex.lock();  // and never unlocked
  for (auto path = uncommitted.rbegin(); path != uncommitted.rend(); ++path)
    std::remove(path->c_str());
}

}  // namespace lipoid
