#pragma once

/// @file
/// Reads several logs side by side.
///
/// Logs of one format, whose header also gives the current the same name, have one sign. A log that
/// says too little about its own gets that of the others, and its report names them. Where the
/// others disagree, it stays open: its error names two that do. A log that contradicts itself is
/// settled by none, and `current_sign` in the options of a log always wins.
/// Tests: tests/identify/logs/read_logs_test.cc.

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "identify/logs/log.h"

namespace lipoid {

struct LogToRead {
  std::string file;
  ReadOptions options;
};

/// Hands each log to `take` with its index, from several threads, as soon as it is read, so that
/// not all need to be kept. What is wrong with a file, or is thrown by `take` as a LoadError, is
/// returned under its index.
[[nodiscard]] std::vector<std::vector<Diagnostic>> ReadLogs(
    const std::vector<LogToRead>& logs, const std::function<void(std::size_t, Log)>& take);

}  // namespace lipoid
