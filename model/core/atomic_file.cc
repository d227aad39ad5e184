#include "model/core/atomic_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <set>
#include <utility>

#include "model/core/errors.h"
#include "model/core/json.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

// What has to go if the program ends now, in the order in which it came; and who commits.
std::mutex mutex;
std::vector<std::string> uncommitted;
FileSet* innermost = nullptr;

// Files that are complete and wait for their FileSet without a name: the open file of the name that
// each will have. Descriptors are few: beyond so many, files wait under their hidden names.
constexpr std::size_t kMostNameless = 64;
std::map<std::string, int> nameless;

void Forget(const std::string& path) {
  const auto found = std::find(uncommitted.begin(), uncommitted.end(), path);
  if (found != uncommitted.end()) uncommitted.erase(found);
}

void Remove(const std::string& path) {
  if (const auto waiting = nameless.find(path); waiting != nameless.end()) {
    ::close(waiting->second);
    nameless.erase(waiting);
  } else {
    ::unlink(path.c_str());
  }
  Forget(path);
}

// A file that waits without a name fills its folder like one that has a name.
bool IsAwaited(const std::string& folder) {
  return std::any_of(nameless.begin(), nameless.end(), [&](const auto& waiting) {
    std::error_code none;
    return fs::absolute(waiting.first, none).lexically_normal().parent_path() == folder;
  });
}

void RemoveFolders(std::vector<std::string>& folders) {
  for (auto path = folders.rbegin(); path != folders.rend(); ++path) {
    // Fails where someone else put something into it: then it stays.
    if (!IsAwaited(*path)) ::rmdir(path->c_str());
    Forget(*path);
  }
  folders.clear();
}

// Where process numbers mean what they mean here: this start of this machine, and this container.
// 0 where nobody can say.
std::uint32_t ThisMachine() {
  static const std::uint32_t machine = [] {
    struct stat processes {};
    std::ifstream stream("/proc/sys/kernel/random/boot_id");
    std::string start;
    if (!(stream >> start) || ::stat("/proc/self/ns/pid", &processes) != 0) return 0U;
    std::uint32_t hash = 2166136261U;  // FNV-1a
    for (const char c : start + std::to_string(processes.st_ino))
      hash = (hash ^ static_cast<unsigned char>(c)) * 16777619U;
    return hash;
  }();
  return machine;
}

// What hidden names begin with: machine and process.
std::string HiddenPrefix(std::uint32_t machine, long process) {
  return fmt::format(".lipoid-{:08x}-{}-", machine, process);
}

// A hidden name in the folder of `target` that nobody is likely to have: hidden, so that no list of
// logs takes it for one, and short, so that it fits wherever the target's name does.
std::string TemporaryName(const std::string& target) {
  const std::string prefix = HiddenPrefix(ThisMachine(), ::getpid());
  static std::uint64_t count = 0;
  std::uint64_t x =
      static_cast<std::uint64_t>(std::chrono::system_clock::now().time_since_epoch().count());
  x += ++count * 0x9E3779B97F4A7C15ULL;
  x = (x ^ (x >> 30U)) * 0xBF58476D1CE4E5B9ULL;
  x = (x ^ (x >> 27U)) * 0x94D049BB133111EBULL;
  return (fs::path(target).parent_path() / fmt::format("{}{:08x}.tmp", prefix, x >> 32U)).string();
}

// What programs that were killed left in the folder of `target`, as far as it is seen that they run
// no more: the second names of files, and files that were not done. Once for each folder.
void RemoveLeftOvers(const std::string& target) {
  static std::set<std::string> seen;
  constexpr int kMostEntries = 10'000;  // a larger folder is not looked through
  std::error_code none;
  const std::string folder = fs::absolute(target, none).lexically_normal().parent_path().string();
  if (none || !seen.insert(folder).second) return;
  const std::uint32_t machine = ThisMachine();
  if (machine == 0) return;
  std::vector<fs::path> left;
  int entries = 0;
  for (fs::directory_iterator at(folder, none), end; !none && at != end; at.increment(none)) {
    if (++entries > kMostEntries) return;
    const std::string name = at->path().filename().string();
    unsigned named_machine = 0;
    long process = 0;
    int length = 0;
    if (!name.ends_with(".tmp") ||
        std::sscanf(name.c_str(), ".lipoid-%8x-%ld-%n", &named_machine, &process, &length) != 2 ||
        name.compare(0, static_cast<std::size_t>(length), HiddenPrefix(machine, process)) != 0)
      continue;
    if (process > 0 && ::kill(static_cast<pid_t>(process), 0) != 0 && errno == ESRCH)
      left.push_back(at->path());
  }
  for (const fs::path& path : left) ::unlink(path.c_str());
}

// make(name) until the name was free. False with errno where something else is in the way.
template <class Make>
bool WithFreeName(const std::string& target, std::string& name, Make&& make) {
  for (int attempt = 0; attempt < 100; ++attempt) {
    name = TemporaryName(target);
    if (make(name.c_str())) return true;
    if (errno != EEXIST) return false;
  }
  return false;
}

// How an open file is found that has no name.
std::string NameOfDescriptor(int descriptor) { return fmt::format("/proc/self/fd/{}", descriptor); }

// A file in the folder of `target` that has no name yet: whatever ends the program, nothing of it is
// left. -1 where the file system or a system without /proc cannot give it a name later.
int OpenNameless(const std::string& target, mode_t mode) {
  const std::string folder = fs::path(target).parent_path().string();
  constexpr int kNameless = O_WRONLY | O_TMPFILE | O_CLOEXEC;
  const int descriptor = ::open(folder.empty() ? "." : folder.c_str(), kNameless, mode);
  if (descriptor < 0 || ::access(NameOfDescriptor(descriptor).c_str(), F_OK) == 0)
    return descriptor;
  ::close(descriptor);
  return -1;
}

bool GiveName(int descriptor, const char* name) {
  const std::string open_file = NameOfDescriptor(descriptor);
  return ::linkat(AT_FDCWD, open_file.c_str(), AT_FDCWD, name, AT_SYMLINK_FOLLOW) == 0;
}

// The hidden name that it waits under, or will have when it needs one; empty with errno where it
// cannot have one.
std::string NameOfNameless(int descriptor, const std::string& target) {
  std::string name = TemporaryName(target);
  const int kept = nameless.size() < kMostNameless ? ::fcntl(descriptor, F_DUPFD_CLOEXEC, 0) : -1;
  if (kept >= 0) {
    nameless[name] = kept;
  } else if (!WithFreeName(
                 target, name, [&](const char* free) { return GiveName(descriptor, free); })) {
    return "";
  }
  uncommitted.push_back(name);
  return name;
}

// Where it waited without a name, it gets the one that was meant for it. False with errno where it
// cannot.
bool HasName(const std::string& temporary) {
  const auto waiting = nameless.find(temporary);
  if (waiting == nameless.end()) return true;
  if (!GiveName(waiting->second, temporary.c_str())) return false;
  ::close(waiting->second);
  nameless.erase(waiting);
  return true;
}

// The descriptor that /dev/stdout or /dev/fd/3 stands for; -1 for other names.
int OpenedAlready(std::string_view path) {
  if (path == "/dev/stdout") return STDOUT_FILENO;
  if (path == "/dev/stderr") return STDERR_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!path.starts_with(folder)) continue;
    const std::string_view number = path.substr(folder.size());
    int descriptor = -1;
    const auto [end, error] =
        std::from_chars(number.data(), number.data() + number.size(), descriptor);
    if (error == std::errc{} && end == number.data() + number.size()) return descriptor;
  }
  return -1;
}

// As the file that is replaced. The owner first: changing it takes the set-user bits away.
void TakeOver(int descriptor, const struct stat& old) {
  struct stat now {};
  mode_t mode = old.st_mode & 07777U;
  const bool owned =
      ::fstat(descriptor, &now) == 0 && ((now.st_uid == old.st_uid && now.st_gid == old.st_gid) ||
                                         ::fchown(descriptor, old.st_uid, old.st_gid) == 0);
  if (!owned) mode &= 01777U;
  (void)::fchmod(descriptor, mode);
}

}  // namespace

std::string BehindLinks(const std::string& path) {
  constexpr int kMostLinks = 40;  // as the kernel follows
  fs::path at = path;
  std::error_code none;
  for (int link = 0; link < kMostLinks && fs::is_symlink(fs::symlink_status(at, none)); ++link) {
    const fs::path next = fs::read_symlink(at, none);
    if (none) break;
    at = next.is_absolute() ? next : at.parent_path() / next;
  }
  return at.string();
}

AtomicFile::AtomicFile(std::string path, const std::string& model) : path_(std::move(path)) {
  errno = 0;
  Open(model.empty() ? path_ : model);
  if (file_ != nullptr) return;
  const int error = errno;
  Fail(std::string(std::strerror(error)) + (error == ENOENT ? "; make its folder first" : ""));
}

void AtomicFile::Open(const std::string& model) {
  if (const int opened = OpenedAlready(path_); opened >= 0) {
    // Where it leads to a regular file, that file is the shell's and is not replaced; and to open a
    // pipe anew would wait for a reader who may have left.
    const int descriptor = ::dup(opened);
    if (descriptor >= 0) file_ = ::fdopen(descriptor, "wb");
    return;
  }
  struct stat old {};
  const bool exists = ::stat(path_.c_str(), &old) == 0;
  const bool named_as_folder = path_.empty() || path_.back() == '/';
  if (named_as_folder || (exists && S_ISDIR(old.st_mode))) {
    throw OptionError(fmt::format("cannot write '{}': expected the name of a file", path_));
  }
  if (!exists && errno != ENOENT) return;  // a loop of links, a name too long, a file as a folder
  if (exists && !S_ISREG(old.st_mode)) {
    file_ = std::fopen(path_.c_str(), "wb");
    return;
  }
  target_ = BehindLinks(path_);
  if (exists && ::access(target_.c_str(), W_OK) != 0) return;
  has_other_names_ = exists && old.st_nlink > 1;
  struct stat of_model {};
  const bool has_model = ::stat(model.c_str(), &of_model) == 0 && S_ISREG(of_model.st_mode);
  const mode_t mode = has_model ? 0600 : 0666;
  const std::scoped_lock lock(mutex);
  RemoveLeftOvers(target_);
  int descriptor = OpenNameless(target_, mode);
  if (descriptor < 0) {
    std::string temporary;
    const bool made = WithFreeName(target_, temporary, [&](const char* name) {
      constexpr int kNew = O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC;
      descriptor = ::open(name, kNew, mode);
      return descriptor >= 0;
    });
    if (!made) return;
    temporary_ = temporary;
    uncommitted.push_back(temporary_);
  }
  if (has_model) TakeOver(descriptor, of_model);
  file_ = ::fdopen(descriptor, "wb");
}

AtomicFile::~AtomicFile() {
  if (file_ != nullptr) std::fclose(file_);
  if (temporary_.empty()) return;
  const std::scoped_lock lock(mutex);
  Remove(temporary_);
}

void AtomicFile::Write(std::string_view bytes) {
  if (reader_left_ || std::fwrite(bytes.data(), 1, bytes.size(), file_) == bytes.size()) return;
  if (!target_.empty() || errno != EPIPE) Fail(std::strerror(errno));
  reader_left_ = true;
}

void AtomicFile::Commit() {
  int error = 0;
  if (std::fflush(file_) != 0) error = errno;
  if (error == 0 && !target_.empty() && ::fsync(::fileno(file_)) != 0) error = errno;
  if (error == 0 && !target_.empty() && temporary_.empty()) {
    const std::scoped_lock lock(mutex);
    temporary_ = NameOfNameless(::fileno(file_), target_);
    if (temporary_.empty()) error = errno;
  }
  if (std::fclose(std::exchange(file_, nullptr)) != 0 && error == 0) error = errno;
  if (target_.empty()) {
    if (error != 0 && error != EPIPE && !reader_left_) Fail(std::strerror(error));
    return;
  }
  if (error != 0) Fail(std::strerror(error));
  const std::scoped_lock lock(mutex);
  FileSet::Waiting waiting{temporary_, target_, path_, has_other_names_};
  if (innermost != nullptr) {
    innermost->files_.push_back(std::move(waiting));
  } else {
    FileSet::Publish({std::move(waiting)});
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

FileSet::FileSet() {
  const std::scoped_lock lock(mutex);
  outer_ = std::exchange(innermost, this);
}

FileSet::~FileSet() {
  const std::scoped_lock lock(mutex);
  innermost = outer_;
  for (const Waiting& file : files_) Remove(file.temporary);
  RemoveFolders(folders_);
}

void FileSet::Commit() {
  const std::scoped_lock lock(mutex);
  if (outer_ != nullptr) {
    outer_->files_.insert(outer_->files_.end(), files_.begin(), files_.end());
    outer_->folders_.insert(outer_->folders_.end(), folders_.begin(), folders_.end());
  } else {
    Publish(files_);
    for (const std::string& folder : folders_) Forget(folder);
    for (const Waiting& file : files_) {
      if (file.has_other_names) one_name_of_.push_back(file.path);
    }
  }
  files_.clear();
  folders_.clear();
}

// Each name, before it gets its new file, lends its old one a second name, which goes at the end.
// The mutex is held: who ends the program waits until all is done.
void FileSet::Publish(const std::vector<Waiting>& files) {
  std::vector<std::string> before(files.size());  // "": there was none
  const auto restore = [&](std::size_t from) {
    for (std::size_t k = from + 1; k-- > 0;) {
      if (!before[k].empty()) {
        std::rename(before[k].c_str(), files[k].target.c_str());
        ::unlink(before[k].c_str());  // still there where both are names of the same file
      } else if (k < from) {
        ::unlink(files[k].target.c_str());
      }
    }
  };
  for (std::size_t k = 0; k < files.size(); ++k) {
    const char* const target = files[k].target.c_str();
    struct stat old {};
    const bool may_be_undone = k + 1 < files.size() && ::lstat(target, &old) == 0;
    bool set_aside = true;
    if (may_be_undone && !S_ISDIR(old.st_mode)) {
      set_aside = WithFreeName(
          files[k].target, before[k], [&](const char* name) { return ::link(target, name) == 0; });
      if (!set_aside) {
        // A file system without hard links: the old file goes out of the way, under a name that
        // nobody clears away, since for a moment it is the only one.
        before[k] += ".old";
        set_aside = std::rename(target, before[k].c_str()) == 0;
      }
      if (!set_aside) before[k].clear();
    }
    // A link cannot replace a file, so that for a moment it has a hidden name.
    if (set_aside && HasName(files[k].temporary) &&
        std::rename(files[k].temporary.c_str(), target) == 0)
      continue;
    const int error = errno;
    restore(k);
    throw OptionError(fmt::format("cannot write '{}': {}", files[k].path, std::strerror(error)));
  }
  for (const std::string& name : before) {
    if (!name.empty()) ::unlink(name.c_str());
  }
  for (const Waiting& file : files) Forget(file.temporary);
}

std::string KeepCopy(const std::string& path) {
  const fs::path file = BehindLinks(path);
  const std::string bytes = ReadTextFile(path);
  for (int number = 1;; ++number) {
    const fs::path copy =
        file.parent_path() /
        fmt::format("{}.{}{}", file.stem().string(), number, file.extension().string());
    std::error_code none;
    if (fs::exists(fs::symlink_status(copy, none))) continue;
    AtomicFile kept(copy.string(), path);
    kept.Write(bytes);
    kept.Commit();
    return copy.string();
  }
}

NewFolder::NewFolder(const std::string& folder) {
  std::vector<std::string> missing;  // deepest first
  std::error_code error;
  for (auto path = fs::absolute(folder, error).lexically_normal();
       !error && !fs::exists(path, error) && !error;
       path = path.parent_path()) {
    if (path.has_filename()) missing.push_back(path.string());
  }
  const std::scoped_lock lock(mutex);
  for (auto path = missing.rbegin(); path != missing.rend() && !error; ++path) {
    if (!fs::create_directory(*path, error)) continue;
    made_.push_back(*path);
    uncommitted.push_back(*path);
  }
  if (!error && !fs::is_directory(folder, error) && !error)
    error = std::make_error_code(std::errc::not_a_directory);
  if (!error) return;
  RemoveFolders(made_);
  throw OptionError(fmt::format("cannot make the folder '{}': {}", folder, error.message()));
}

NewFolder::~NewFolder() {
  const std::scoped_lock lock(mutex);
  RemoveFolders(made_);
}

void NewFolder::Keep() {
  const std::scoped_lock lock(mutex);
  if (innermost != nullptr) {
    innermost->folders_.insert(innermost->folders_.end(), made_.begin(), made_.end());
  } else {
    for (const auto& path : made_) Forget(path);
  }
  made_.clear();
}

void RemoveUncommitted() noexcept {
  mutex.lock();  // and never unlocked
  for (auto path = uncommitted.rbegin(); path != uncommitted.rend(); ++path)
    std::remove(path->c_str());
}

}  // namespace lipoid
