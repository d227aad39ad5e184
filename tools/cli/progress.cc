#include "tools/cli/progress.h"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <cstdlib>

#include "model/core/foreign_text.h"

namespace lipoid::cli {
namespace {

// The descriptor that the environment names, where it is an open pipe.
int ProgressPipe() {
  const char* const text = std::getenv(kProgressVariable);
  if (text == nullptr) return -1;
  const std::string_view digits(text);
  int descriptor = -1;
  const auto [end, error] =
      std::from_chars(digits.data(), digits.data() + digits.size(), descriptor);
  struct stat status {};
  const bool pipe = error == std::errc{} && end == digits.data() + digits.size() &&
                    descriptor > STDERR_FILENO && ::fstat(descriptor, &status) == 0 &&
                    S_ISFIFO(status.st_mode);
  return pipe ? descriptor : -1;
}

}  // namespace

bool ErrorIsTerminal() { return ::isatty(STDERR_FILENO) == 1; }

bool ErrorIsColoured() {
  const char* no_color = std::getenv("NO_COLOR");  // no-color.org: set and not empty
  const char* terminal = std::getenv("TERM");
  return ErrorIsTerminal() && (no_color == nullptr || *no_color == '\0') &&
         (terminal == nullptr || std::string_view(terminal) != "dumb");
}

Progress::Progress(bool enabled) : enabled_(enabled && ErrorIsTerminal()), pipe_(ProgressPipe()) {}

void Progress::Update(double fraction, std::string_view what) {
  if (!enabled_ && pipe_ < 0) return;
  const std::scoped_lock lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (updated_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  updated_ = true;
  const double share = fraction > 0.0 ? std::min(fraction, 1.0) : 0.0;
  if (pipe_ >= 0) {
    const auto line = fmt::format("{:.3f} {}\n", share, ForeignText(what));
    if (::write(pipe_, line.data(), line.size()) < 0 && errno == EPIPE) ::kill(::getpid(), SIGTERM);
  }
  if (!enabled_) return;
  drawn_ = true;
  constexpr int kWidth = 30;
  const auto filled = static_cast<std::size_t>(share * kWidth);
  const auto bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  const auto text =
      fmt::format("\r\033[K[{}] {:3.0f} % {}", bar, 100.0 * share, what.substr(0, 40));
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void Progress::Wipe() {
  const std::scoped_lock lock(mutex_);
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = updated_ = false;
}

}  // namespace lipoid::cli
