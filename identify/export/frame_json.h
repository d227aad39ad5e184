#pragma once

/// @file
/// Frame models of ArduPilot's simulator: JSON in which the text before the first brace is skipped
/// and # begins a comment up to the end of its line, also inside a text.
/// Tests: tests/identify/export/frame_json_test.cc.

#include <string>
#include <utility>
#include <vector>

namespace lipoid {

/// The text with all that is no JSON blanked, so that lines and columns stay what they were.
/// LoadError where there is no brace.
[[nodiscard]] std::string FrameWithoutComments(const std::string& text, const std::string& file);

/// The frame with these numbers, given as text, in place of its own ones, or as its first keys
/// where it has none; `lines`, each a comment with its line break, behind the first brace. All else
/// stays as it is. LoadError where the text is no frame.
[[nodiscard]] std::string MergeIntoFrame(
    const std::string& text,
    const std::string& file,
    const std::vector<std::pair<std::string, std::string>>& numbers,
    const std::string& lines);

}  // namespace lipoid
