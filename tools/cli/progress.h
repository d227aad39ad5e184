#pragma once

/// @file
/// A progress bar on standard error: drawn only on a terminal, wiped when it is done. Who starts
/// lipoid from a program may read the progress, too, from a pipe that the environment names: see
/// docs/formats.md. Tests: tests/tools/serve/child_test.cc.

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

namespace lipoid::cli {

/// Whether standard error is a terminal, and whether it may be coloured (NO_COLOR is honoured).
[[nodiscard]] bool ErrorIsTerminal();
[[nodiscard]] bool ErrorIsColoured();

/// The variable of the environment that holds the number of the descriptor of such a pipe. A line
/// there is a fraction and words: "0.42 reading logs".
inline constexpr const char* kProgressVariable = "LIPOID_PROGRESS_FD";

class Progress {
 public:
  explicit Progress(bool enabled);
  ~Progress() { Wipe(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// fraction in [0, 1]. From any thread; redraws at most ten times a second. Where the reader of the
  /// pipe is gone, nobody waits for the result: the process is told to end (SIGTERM).
  void Update(double fraction, std::string_view what);
  /// Clears the line, so that a message can be printed.
  void Wipe();

 private:
  std::mutex mutex_;
  bool enabled_;
  int pipe_;  // -1: none
  bool drawn_ = false;
  bool updated_ = false;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace lipoid::cli
