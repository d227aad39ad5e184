#pragma once

/// @file
/// The series of samples that a page needs beside a summary, made again by the command that wrote
/// the summary: from the same arguments and the same files, or not at all.
/// Tests: tests/tools/report_command_test.cc.

#include <span>

#include "tools/cli/command_line.h"
#include "tools/report/report.h"

namespace lipoid {

/// The summary with its series, where its command has any. Notes say why they are not there: an
/// input that is missing or has changed, or what the command said.
[[nodiscard]] ReportResult Replayed(Json summary, std::span<const cli::Command> commands);

}  // namespace lipoid
