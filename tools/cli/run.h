#pragma once

/// @file
/// Dispatch: finds the command, runs it, and turns whatever happens into one exit code, a message
/// on standard error and, where --summary asks for it, a JSON file. Tests: tests/tools/.

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/cli/command_line.h"

namespace lipoid::cli {

/// The exit codes, for help and manual page.
inline constexpr std::string_view kExitCodes =
    "0 done, 1 not converged or not completed, 2 usage, 3 bad input, 4 internal error.";

/// The exit code of `lipoid arguments...`. Never throws.
[[nodiscard]] int Run(std::span<const Command> commands,
                      std::vector<std::string> arguments) noexcept;

/// Runs `task` where it has room: on a stack of its own, whatever the limit of the shell (`ulimit
/// -s`) leaves the first thread. Where no further thread may be started, on that of the caller.
[[nodiscard]] int OnLargeStack(const std::function<int()>& task);

/// From now on memory that was freed stays with the process, up to some 100 MB a thread, and blocks of up to 32 MB do not
/// go back one by one: fits free and take the same blocks thousands of times, and the kernel would clear
/// each anew. Where the C library is not glibc nothing happens.
void KeepFreedMemory();

/// From now on the process, when it is interrupted or told to end, first removes what it has
/// half-written. Call it before other threads start.
void CleanUpWhenEnded();

/// While one is there, the first interrupt (SIGINT), SIGTERM or SIGHUP (the terminal is closed) calls
/// `stop`, from another thread, instead of ending the process: for a command that runs until it is told otherwise and then has
/// something to say. The second ends it. One at a time.
class StopRequest {
 public:
  explicit StopRequest(std::function<void()> stop);
  ~StopRequest();
  StopRequest(const StopRequest&) = delete;
  StopRequest& operator=(const StopRequest&) = delete;
};

}  // namespace lipoid::cli
