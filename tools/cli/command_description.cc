#include "tools/cli/command_description.h"

#include <algorithm>
#include <cctype>

namespace lipoid::cli {

bool DescribedOption::TakesFile() const {
  // The values that are no file are written as choices, ranges or words in lower case.
  return !value.empty() && std::all_of(value.begin(), value.end(), [](unsigned char c) {
    return std::isupper(c) != 0 || c == '_' || c == '.';
  });
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

std::vector<CommandDescription> DescribeCommands(std::span<const Command> commands) {
  std::vector<CommandDescription> all;
  for (const auto& command : commands) {
    CommandLine line(command, {"--help"});
    static_cast<void>(command.run(line));
    all.push_back(line.Description());
  }
  return all;
}

}  // namespace lipoid::cli
