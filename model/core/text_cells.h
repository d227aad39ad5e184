#pragma once

/// @file
/// The cells of a line of a delimited text file, and what stands in one: a number, a quoted text.
/// No locale; anything that is not wholly what it should be is refused.
/// Tests: tests/identify/logs/csv/table_reader_test.cc.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// Surrounding blanks, tabs, carriage returns and no-break spaces removed.
[[nodiscard]] std::string_view Trimmed(std::string_view text);

/// A..Z to a..z; other bytes stay.
[[nodiscard]] std::string LowerCase(std::string_view text);

/// A decimal number, perhaps with a sign, an exponent, or the given decimal mark. `nan` and `inf`
/// parse.
[[nodiscard]] bool ParseNumber(std::string_view text, char decimal, double& value);

/// One cell of a line: its text without quotes and blanks, and the column (from 1) where it begins.
struct TextCell {
  std::string_view text;
  std::size_t column = 1;
};

/// The cells of a line, which comes without its line end. A quoted cell keeps doubled quotes as
/// they are.
void SplitLine(std::string_view line, char delimiter, std::vector<TextCell>& cells);

/// What is inside a line that is one quoted text, "a,b,c": some exports wrap each row so. Other
/// lines as they are.
[[nodiscard]] std::string_view Unwrapped(std::string_view line, char delimiter);

}  // namespace lipoid
