#pragma once

/// @file
/// The only list of log formats, and the recognition of a file by its content.
/// To add a format: a Layout in identify/logs/formats/ and a row in formats.cc.
/// Tests: tests/identify/logs/formats/formats_test.cc.

#include <span>
#include <string>

#include "identify/logs/formats/plan_columns.h"

namespace lipoid {

/// All formats, sorted by name.
[[nodiscard]] std::span<const Layout* const> LogFormats();

/// Whether the file is no log at all (NoLogError), by its head.
[[nodiscard]] bool IsNoLog(const std::string& file, const ReadOptions& options);

/// Recognises the file, resolves its columns and units, and leaves the source at the first line
/// after the header. LoadError with a position and advice where that cannot be done.
[[nodiscard]] LogPlan PlanReading(TextSource& source, const ReadOptions& options);

}  // namespace lipoid
