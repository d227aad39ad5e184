#include "tools/serve/session_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <vector>

#include "model/core/errors.h"

namespace lipoid {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPrefix = "lipoid-serve-";
constexpr const char* kLock = "lock";
// A folder without a lock may be one that another server is about to lock.
constexpr std::time_t kYoung_s = 60;

fs::path TemporaryFolder() {
  std::error_code none;
  const fs::path folder = fs::temp_directory_path(none);
  if (none) {
    throw OptionError(
        fmt::format("the folder of temporary files cannot be used: {}; set TMPDIR to one that can",
                    none.message()));
  }
  return folder;
}

// Whether the server of this folder is gone. The folder is this user's, so nobody else can put
// anything into it.
bool IsAbandoned(const fs::path& folder) {
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode)) return false;
  if (status.st_uid != ::geteuid() || (status.st_mode & 0077) != 0) return false;
  const int lock = ::open((folder / kLock).c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC);
  if (lock < 0) return errno == ENOENT && std::time(nullptr) - status.st_mtime > kYoung_s;
  const bool abandoned = ::flock(lock, LOCK_EX | LOCK_NB) == 0;
  ::close(lock);
  return abandoned;
}

}  // namespace

SessionFolder::SessionFolder() {
  std::string name = (TemporaryFolder() / (std::string(kPrefix) + "XXXXXX")).string();
  if (::mkdtemp(name.data()) == nullptr) {  // with mode 0700
    throw OptionError(fmt::format(
        "cannot make a folder for the session: '{}': {}; set TMPDIR to a folder that can be written",
        name,
        std::strerror(errno)));
  }
  path_ = name;
  lock_ = ::open((path_ + "/" + kLock).c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (lock_ < 0 || ::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
    const std::string why = std::strerror(errno);
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    if (lock_ >= 0) ::close(lock_);
    throw OptionError(fmt::format("cannot lock a file in '{}': {}", path_, why));
  }
}

SessionFolder::~SessionFolder() {
  std::error_code ignored;
  fs::remove_all(path_, ignored);
  ::close(lock_);
}

int SessionFolder::Sweep() {
  std::error_code ignored;
  std::vector<fs::path> abandoned;
  for (fs::directory_iterator each(TemporaryFolder(), ignored), end; !ignored && each != end;
       each.increment(ignored)) {
    if (each->path().filename().string().starts_with(kPrefix) && IsAbandoned(each->path()))
      abandoned.push_back(each->path());
  }
  int removed = 0;
  for (const fs::path& folder : abandoned) {
    std::error_code trouble;
    fs::remove_all(folder, trouble);
    if (!trouble) ++removed;
  }
  return removed;
}

}  // namespace lipoid
