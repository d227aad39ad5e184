#include "tools/cli/help_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>

#include "tools/cli/text_table.h"

namespace lipoid::cli {
namespace {

// "  --name VALUE    help", the help wrapped beside it.
void AddHelpLine(std::string& text, const std::string& left, const std::string& help) {
  constexpr std::size_t kColumn = 30;
  text += "  " + left;
  if (left.size() + 4 > kColumn) {
    text += '\n' + std::string(kColumn, ' ');
  } else {
    text += std::string(kColumn - 2 - left.size(), ' ');
  }
  text += Wrapped(help, kColumn) + '\n';
}

// As one types it: what does not fit into a line goes on, before an option, behind a backslash.
std::string InLines(std::string_view command) {
  constexpr std::size_t kMost = 95;  // of 100, with the indent and the backslash
  std::string text;
  std::size_t used = 0;
  while (!command.empty()) {
    const std::size_t end = std::min(command.find(" -", 1), command.size());
    if (used > 0 && used + end > kMost) {
      text += " \\\n     ";
      used = 5;
    }
    text += command.substr(0, end);
    used += end;
    command.remove_prefix(end);
  }
  return text;
}

}  // namespace

std::string HelpText(const CommandDescription& command) {
  std::string usage = fmt::format("lipoid {}", command.name);
  for (const auto& argument : command.arguments) {
    usage += argument.required ? " " + argument.name : fmt::format(" [{}]", argument.name);
    if (argument.several) usage += "...";
  }
  for (const auto& option : command.options) {
    if (!option.required) continue;
    usage += option.letter == '\0' ? fmt::format(" --{} {}", option.name, option.value)
                                   : fmt::format(" -{} {}", option.letter, option.value);
  }
  std::string text = fmt::format("Usage: {} [options]\n\n{}\n", usage, Wrapped(command.what));
  text += command.examples.size() > 1 ? "\nExamples:\n" : "\nExample:\n";
  for (const auto& example : command.examples) text += "  " + InLines(example) + "\n";

  if (!command.arguments.empty()) {
    text += "\nArguments:\n";
    for (const auto& argument : command.arguments) AddHelpLine(text, argument.name, argument.help);
  }
  const auto add_options = [&](std::string_view title, bool common) {
    bool first = true;
    for (const DescribedOption& option : command.options) {
      if (option.common != common) continue;
      if (first) text += fmt::format("\n{}:\n", title);
      first = false;
      AddHelpLine(text, option.ShownWithValue(), option.Help());
    }
  };
  add_options("Options", false);
  add_options("Common options", true);
  if (!command.settings.empty()) text += "\nOptions for --set OPTION=VALUE:\n";
  for (const auto& setting : command.settings) AddHelpLine(text, setting.name, setting.Help());
  return text;
}

}  // namespace lipoid::cli
