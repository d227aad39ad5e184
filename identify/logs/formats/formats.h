#pragma once

/// @file
/// The only list of log formats, and the recognition of a file by its content.
/// To add a format: a Layout in identify/logs/formats/ and a row in formats.cc.
/// Tests: tests/identify/logs/formats/formats_test.cc.

#include <span>

#include "identify/logs/formats/plan_columns.h"

namespace lipoid {

/// All formats, sorted by name.
[[nodiscard]] std::span<const Layout* const> LogFormats();

/// Recognises the file, resolves its columns and units, and leaves the source at the first line
/// after the header. LoadError with a position and advice where that cannot be done.
[[nodiscard]] LogPlan PlanReading(TextSource& source, const ReadOptions& options);

}  // namespace lipoid
