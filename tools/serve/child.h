#pragma once

/// @file
/// A run of this same program as a process of its own: what it computes cannot stop the server, and
/// it can be stopped at any time. Tests: tests/tools/serve/child_test.cc.

#include <functional>
#include <stop_token>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

struct ChildPlan {
  std::string program;                 ///< "/proc/self/exe" is this one
  std::vector<std::string> arguments;  ///< without the name of the program
  std::string folder;                  ///< where it runs
  std::string output_file;             ///< what it writes to standard output
  std::string message_file;            ///< and to standard error
};

struct ChildEnd {
  int exit_code = -1;    ///< where it ended by itself
  int signal = 0;        ///< where one ended it
  bool stopped = false;  ///< it was asked to end before it did
};

/// Called by the thread that waits, with what the child says of its progress.
using ChildProgress = std::function<void(double fraction, std::string_view doing)>;

/// Runs it and waits for its end. A stop ends it and all that it started: with SIGTERM, upon which
/// it removes what it has half-written, and with SIGKILL where that is not enough. Throws
/// std::system_error where it cannot be started.
[[nodiscard]] ChildEnd RunChild(const ChildPlan& plan,
                                const std::stop_token& stop,
                                const ChildProgress& progress);

}  // namespace lipoid
