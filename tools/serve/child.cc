#include "tools/serve/child.h"

#include <fcntl.h>
#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <system_error>

#include "tools/cli/progress.h"

namespace lipoid {
namespace {

using Clock = std::chrono::steady_clock;

// How often the end of the child and a wish to stop are looked for.
constexpr int kLook_ms = 50;
// After SIGTERM so long until SIGKILL.
constexpr auto kPatience = std::chrono::seconds(5);
constexpr int kProgressDescriptor = 3;

[[noreturn]] void Fail(int error, const char* what) {
  throw std::system_error(error, std::generic_category(), what);
}

class Descriptor {
 public:
  explicit Descriptor(int descriptor) : descriptor_(descriptor) {}
  ~Descriptor() { Close(); }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  void Close() {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = -1;
  }
  [[nodiscard]] int get() const { return descriptor_; }

 private:
  int descriptor_;
};

// What posix_spawn is told, freed at the end.
struct SpawnSettings {
  posix_spawn_file_actions_t actions;
  posix_spawnattr_t attributes;

  SpawnSettings() {
    posix_spawn_file_actions_init(&actions);
    posix_spawnattr_init(&attributes);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;
};

pid_t Start(const ChildPlan& plan, int progress) {
  SpawnSettings settings;
  auto* const actions = &settings.actions;
  posix_spawn_file_actions_addopen(actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  constexpr int kNew = O_WRONLY | O_CREAT | O_TRUNC;
  posix_spawn_file_actions_addopen(actions, STDOUT_FILENO, plan.output_file.c_str(), kNew, 0600);
  posix_spawn_file_actions_addopen(actions, STDERR_FILENO, plan.message_file.c_str(), kNew, 0600);
  posix_spawn_file_actions_adddup2(actions, progress, kProgressDescriptor);
  // Neither the server's connections nor its lock live on in the child.
  posix_spawn_file_actions_addclosefrom_np(actions, kProgressDescriptor + 1);
  posix_spawn_file_actions_addchdir_np(actions, plan.folder.c_str());

  // A process group of its own, which a stop ends as a whole; and no signal blocked or ignored.
  sigset_t signals;
  sigemptyset(&signals);
  posix_spawnattr_setsigmask(&settings.attributes, &signals);
  sigfillset(&signals);
  posix_spawnattr_setsigdefault(&settings.attributes, &signals);
  posix_spawnattr_setpgroup(&settings.attributes, 0);
  posix_spawnattr_setflags(&settings.attributes,
                           POSIX_SPAWN_SETPGROUP | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);

  std::vector<std::string> words = {"lipoid"};
  words.insert(words.end(), plan.arguments.begin(), plan.arguments.end());
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  std::string progress_variable =
      std::string(cli::kProgressVariable) + "=" + std::to_string(kProgressDescriptor);
  std::vector<char*> environment = {progress_variable.data()};
  for (char** variable = environ; *variable != nullptr; ++variable)
    environment.push_back(*variable);
  environment.push_back(nullptr);

  pid_t child = 0;
  const int error = posix_spawn(&child,
                                plan.program.c_str(),
                                &settings.actions,
                                &settings.attributes,
                                arguments.data(),
                                environment.data());
  if (error != 0) Fail(error, "cannot start a process");
  return child;
}

// Lines "0.42 reading logs".
class ProgressLines {
 public:
  explicit ProgressLines(const ChildProgress& progress) : progress_(progress) {}

  void Take(std::string_view bytes) {
    text_ += bytes;
    for (auto end = text_.find('\n'); end != std::string::npos; end = text_.find('\n')) {
      Line(std::string_view(text_).substr(0, end));
      text_.erase(0, end + 1);
    }
    if (text_.size() > kMostBytes) text_.clear();
  }

 private:
  static constexpr std::size_t kMostBytes = 4096;

  void Line(std::string_view line) {
    double fraction = 0.0;
    const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), fraction);
    if (error != std::errc{} || !(fraction >= 0.0 && fraction <= 1.0)) return;
    std::string_view doing(end, static_cast<std::size_t>(line.data() + line.size() - end));
    if (doing.starts_with(' ')) doing.remove_prefix(1);
    progress_(fraction, doing);
  }

  const ChildProgress& progress_;
  std::string text_;
};

}  // namespace

ChildEnd RunChild(const ChildPlan& plan,
                  const std::stop_token& stop,
                  const ChildProgress& progress) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) Fail(errno, "cannot make a pipe");
  Descriptor reading(ends[0]);
  Descriptor writing(ends[1]);
  const pid_t child = Start(plan, writing.get());
  writing.Close();

  ChildEnd end;
  ProgressLines lines(progress);
  Clock::time_point asked;
  bool killed = false;
  std::array<char, 4096> bytes{};
  while (true) {
    pollfd look{.fd = reading.get(), .events = POLLIN, .revents = 0};
    if (::poll(&look, 1, kLook_ms) > 0) {
      const ssize_t count = ::read(reading.get(), bytes.data(), bytes.size());
      if (count > 0) {
        lines.Take({bytes.data(), static_cast<std::size_t>(count)});
        if (!stop.stop_requested()) continue;
      } else if (count == 0) {
        reading.Close();  // the child is about to end; poll() waits without it
      }
    }
    int status = 0;
    if (::waitpid(child, &status, WNOHANG) == child) {
      if (WIFSIGNALED(status)) end.signal = WTERMSIG(status);
      if (WIFEXITED(status)) end.exit_code = WEXITSTATUS(status);
      return end;
    }
    if (!stop.stop_requested()) continue;
    if (!end.stopped) {
      end.stopped = true;
      asked = Clock::now();
      ::kill(-child, SIGTERM);
    } else if (!killed && Clock::now() - asked > kPatience) {
      killed = true;
      ::kill(-child, SIGKILL);
    }
  }
}

}  // namespace lipoid
