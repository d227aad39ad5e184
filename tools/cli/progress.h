#pragma once

/// @file
/// A progress bar on standard error: drawn only on a terminal, wiped when it is done.

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

namespace lipoid::cli {

/// Whether standard error is a terminal, and whether it may be coloured (NO_COLOR is honoured).
[[nodiscard]] bool ErrorIsTerminal();
[[nodiscard]] bool ErrorIsColoured();

class Progress {
 public:
  explicit Progress(bool enabled) : enabled_(enabled && ErrorIsTerminal()) {}
  ~Progress() { Wipe(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// fraction in [0, 1]. From any thread; redraws at most ten times a second.
  void Update(double fraction, std::string_view what);
  /// Clears the line, so that a message can be printed.
  void Wipe();

 private:
  std::mutex mutex_;
  bool enabled_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace lipoid::cli
