#include "model/core/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>

#include "model/core/errors.h"

namespace lipoid {

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)) {
  if (path_ == "/dev/stdout") {
    // By its descriptor: where it leads to a regular file, that file is the shell's and is not replaced.
    const int descriptor = ::dup(STDOUT_FILENO);
    if (descriptor >= 0) file_ = ::fdopen(descriptor, "wb");
    if (file_ == nullptr) Fail(std::strerror(errno));
    return;
  }
  // A link stays a link; what it points to is replaced.
  std::error_code dangling;
  if (const auto target = std::filesystem::canonical(path_, dangling); !dangling) path_ = target.string();
  struct stat status {};
  const bool exists = ::stat(path_.c_str(), &status) == 0;
  if (path_.empty() || (exists && S_ISDIR(status.st_mode))) {
    throw OptionError(fmt::format("cannot write '{}': expected the name of a file", path_));
  }
  if (exists && !S_ISREG(status.st_mode)) {
    file_ = std::fopen(path_.c_str(), "wb");
  } else {
    temporary_ = fmt::format("{}.{}.tmp", path_, ::getpid());
    const int descriptor = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (descriptor >= 0) file_ = ::fdopen(descriptor, "wb");
  }
  if (file_ == nullptr) Fail(std::strerror(errno));
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::Write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) Fail(std::strerror(errno));
}

void AtomicFile::Commit() {
  const bool flushed = std::fflush(file_) == 0 && (temporary_.empty() || ::fsync(::fileno(file_)) == 0);
  const bool closed = std::fclose(file_) == 0;
  file_ = nullptr;
  if (!flushed || !closed) Fail(std::strerror(errno));
  if (!temporary_.empty() && std::rename(temporary_.c_str(), path_.c_str()) != 0) {
    Fail(std::strerror(errno));
  }
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

}  // namespace lipoid
