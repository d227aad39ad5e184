#pragma once

/// @file
/// Small text files for tests.

#include <string>
#include <string_view>

namespace lipoid::test {

/// The header of a log in the units of lipoid.
inline const std::string kLogHeader = "time_s,current_A,voltage_V\n";

/// Writes the text to a file, which may be there.
void Write(const std::string& file, std::string_view text);

/// Writes the text, byte for byte, to a file of that name in a folder of the current test.
std::string WriteText(const std::string& name, std::string_view text);

std::string ReadText(const std::string& file);

/// The text with every run of blanks and line breaks as one blank: sentences wrap on a screen.
std::string OnOneLine(std::string_view text);

/// The rest of an indented example of the docs from the line that starts so, up to the first line
/// of text after it.
std::string DocsExample(const std::string& document, const std::string& first_line);

}  // namespace lipoid::test
