#include "tools/cli/command_description.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

namespace lipoid::cli {
namespace {

bool IsShortWord(const std::string& value) { return value.find(' ') == std::string::npos; }

}  // namespace

std::string DescribedOption::Shown() const {
  return letter == '\0' ? "--" + name : fmt::format("-{}, --{}", letter, name);
}

std::string DescribedOption::ShownWithValue() const {
  std::string text = Shown();
  if (!value.empty()) text += " " + (IsShortWord(value) ? value : "VALUE");
  return several ? text + " ..." : text;
}

std::string DescribedOption::Help(bool say_required) const {
  std::string text = help;
  if (!IsShortWord(value)) text += "; " + value;
  if (say_required && required) text += " (required)";
  if (!default_text.empty()) text += fmt::format(" (default {})", default_text);
  return text;
}

std::string CommandDescription::Setting::Help() const {
  return fmt::format("{}; {} (default {})", help, valid, default_text);
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
