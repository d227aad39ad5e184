#include "tools/cli/command_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace lipoid::cli {

std::string DescribedOption::Shown() const {
  return letter == '\0' ? "--" + name : fmt::format("-{}, --{}", letter, name);
}

bool DescribedOption::TakesFile() const {
  // CELL, GAINS and VEHICLE may be names too.
  constexpr std::array<std::string_view, 8> kFiles{
      "CELL", "CSV", "DIR", "FILE", "GAINS", "JSON", "LOG", "VEHICLE"};
  return std::find(kFiles.begin(), kFiles.end(), value) != kFiles.end();
}

std::vector<std::string> DescribedOption::Choices() const {
  std::vector<std::string> choices;
  if (value.find(" | ") == std::string::npos) return choices;
  for (std::size_t from = 0; from <= value.size();) {
    const auto to = std::min(value.find(" | ", from), value.size());
    choices.push_back(value.substr(from, to - from));
    from = to + 3;
  }
  return choices;
}

}  // namespace lipoid::cli
