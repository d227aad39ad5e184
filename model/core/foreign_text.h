#pragma once

/// @file
/// Text that came from elsewhere (a file, the name of a file, the command line) made fit for a
/// message on a terminal: a file may hold megabytes on one line, or sequences that move the cursor,
/// clear the screen or print backwards. All that LoadError says and all that the command line
/// prints passes through here. Tests: tests/model/core/foreign_text_test.cc.

#include <cstddef>
#include <string>
#include <string_view>

namespace lipoid {

/// The most bytes that a message shows of one value, and the most of a whole message.
inline constexpr std::size_t kMostBytesOfValue = 200;
inline constexpr std::size_t kMostBytesOfMessage = 4000;

/// The text with every control character, every byte that is not UTF-8 and every character that
/// changes the direction of writing escaped (\n, \x1b, \u202e). Of more than `most_bytes` only the
/// beginning and the end, and how many bytes there were. Escaping twice changes nothing.
[[nodiscard]] std::string ForeignText(std::string_view text,
                                      std::size_t most_bytes = kMostBytesOfValue);

[[nodiscard]] bool IsUtf8(std::string_view text);

/// ForeignText() of a text of several lines, for each line by itself: at most kMostBytesOfMessage of it.
[[nodiscard]] std::string ForeignLines(std::string_view text);

}  // namespace lipoid
