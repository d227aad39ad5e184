#include "tools/cli/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

namespace lipoid::cli {

bool ErrorIsTerminal() { return ::isatty(STDERR_FILENO) == 1; }

bool ErrorIsColoured() {
  const char* no_color = std::getenv("NO_COLOR");  // no-color.org: set and not empty
  const char* terminal = std::getenv("TERM");
  return ErrorIsTerminal() && (no_color == nullptr || *no_color == '\0') &&
         (terminal == nullptr || std::string_view(terminal) != "dumb");
}

void Progress::Update(double fraction, std::string_view what) {
  if (!enabled_) return;
  const std::scoped_lock lock(mutex_);
  const auto now = std::chrono::steady_clock::now();
  if (drawn_ && now - last_ < std::chrono::milliseconds(100)) return;
  last_ = now;
  drawn_ = true;
  constexpr int kWidth = 30;
  const double share = fraction > 0.0 ? std::min(fraction, 1.0) : 0.0;
  const auto filled = static_cast<std::size_t>(share * kWidth);
  const auto bar = std::string(filled, '#') + std::string(kWidth - filled, '.');
  const auto text =
      fmt::format("\r\033[K[{}] {:3.0f} % {}", bar, 100.0 * share, what.substr(0, 40));
  std::fwrite(text.data(), 1, text.size(), stderr);
}

void Progress::Wipe() {
  const std::scoped_lock lock(mutex_);
  if (drawn_) std::fputs("\r\033[K", stderr);
  drawn_ = false;
}

}  // namespace lipoid::cli
