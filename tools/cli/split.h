#pragma once

/// @file
/// Lists on the command line: "s,A,V", "0.8:0.01:1".

#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// The pieces between separators, empty ones too; one more than there are separators.
[[nodiscard]] inline std::vector<std::string> SplitAt(std::string_view text, char separator) {
  std::vector<std::string> pieces;
  while (true) {
    const auto end = text.find(separator);
    pieces.emplace_back(text.substr(0, end));
    if (end == std::string_view::npos) return pieces;
    text.remove_prefix(end + 1);
  }
}

}  // namespace lipoid
