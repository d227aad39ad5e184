#pragma once

/// @file
/// Words as a shell reads them back. Tests: tests/tools/cli_test.cc.

#include <algorithm>
#include <cctype>
#include <string>
#include <string_view>

namespace lipoid::cli {

/// In single quotes, whatever they hold.
inline std::string ShellQuoted(std::string_view text) {
  std::string quoted = "'";
  for (const char c : text) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

/// The same, without quotes where it needs none.
inline std::string ShellWord(std::string_view word) {
  constexpr std::string_view kPlain = "_-./=,:@%+";
  const bool is_plain = !word.empty() && std::all_of(word.begin(), word.end(), [&](char c) {
    const auto byte = static_cast<unsigned char>(c);
    return byte >= 0x80 || std::isalnum(byte) != 0 || kPlain.find(c) != kPlain.npos;
  });
  return is_plain ? std::string(word) : ShellQuoted(word);
}

}  // namespace lipoid::cli
