#include "tools/cli/completion.h"

#include <fmt/ranges.h>

#include "model/core/errors.h"
#include "model/core/nearest_name.h"
#include "tools/cli/shell_word.h"

namespace lipoid::cli {
namespace {

// With a backslash before each of the characters.
std::string Escaped(std::string_view text, std::string_view characters) {
  std::string safe;
  for (const char c : text) {
    if (characters.find(c) != characters.npos) safe += '\\';
    safe += c;
  }
  return safe;
}

// Fish knows \' and \\ between single quotes.
std::string QuotedForFish(std::string_view text) { return "'" + Escaped(text, "'\\") + "'"; }

std::vector<std::string> Spellings(const DescribedOption& option) {
  std::vector<std::string> all{"--" + option.name};
  if (option.letter != '\0') all.push_back(std::string("-") + option.letter);
  return all;
}

std::vector<std::string> SettingNames(const CommandDescription& command) {
  std::vector<std::string> names;
  for (const auto& setting : command.settings) names.push_back(setting.name + "=");
  return names;
}

std::vector<std::string> CommandNames(std::span<const CommandDescription> commands) {
  std::vector<std::string> names;
  for (const auto& command : commands) names.push_back(command.name);
  return names;
}

std::string BashScript(std::span<const CommandDescription> commands) {
  std::string text =
      "# bash completion of lipoid; made by lipoid --completion bash\n"
      "_lipoid() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} options\n"
      "  COMPREPLY=()\n"
      "  if [ \"$COMP_CWORD\" -eq 1 ]; then\n";
  text += fmt::format(
      "    mapfile -t COMPREPLY < <(compgen -W {} -- \"$word\")\n    return\n  fi\n",
      ShellQuoted(fmt::format("{} help --help --version", fmt::join(CommandNames(commands), " "))));
  text += "  case ${COMP_WORDS[1]} in\n";
  for (const auto& command : commands) {
    std::string options;
    std::string values;
    for (const auto& option : command.options) {
      options += fmt::format("{}{}", options.empty() ? "" : " ", fmt::join(Spellings(option), " "));
      const auto pattern = fmt::format("{}", fmt::join(Spellings(option), "|"));
      const auto words = option.name == "set" ? SettingNames(command) : option.Choices();
      if (!words.empty()) {
        values += fmt::format(
            "        {}) {}mapfile -t COMPREPLY < <(compgen -W {} -- \"$word\"); return ;;\n",
            pattern,
            option.name == "set" ? "compopt -o nospace 2> /dev/null; " : "",
            ShellQuoted(fmt::format("{}", fmt::join(words, " "))));
      } else if (!option.value.empty() && !option.TakesFile()) {
        values += fmt::format("        {}) return ;;\n", pattern);
      }
    }
    text += fmt::format("    {})\n      options={}\n", command.name, ShellQuoted(options));
    if (!values.empty()) text += fmt::format("      case $before in\n{}      esac\n", values);
    text += "      ;;\n";
  }
  text += fmt::format(
      "    help) mapfile -t COMPREPLY < <(compgen -W {} -- \"$word\"); return ;;\n  esac\n",
      ShellQuoted(fmt::format("{}", fmt::join(CommandNames(commands), " "))));
  text +=
      "  if [[ $word == -* ]]; then\n"
      "    mapfile -t COMPREPLY < <(compgen -W \"$options\" -- \"$word\")\n"
      "  else\n"
      "    compopt -o filenames 2> /dev/null\n"
      "    mapfile -t COMPREPLY < <(compgen -f -- \"$word\")\n"
      "  fi\n"
      "}\n"
      "complete -F _lipoid lipoid\n";
  return text;
}

// Text inside a specification of _arguments or _describe.
std::string ForZsh(std::string_view text) { return Escaped(text, "[]:\\"); }

std::string ZshScript(std::span<const CommandDescription> commands) {
  std::string text =
      "#compdef lipoid\n"
      "# zsh completion of lipoid; made by lipoid --completion zsh\n"
      "_lipoid() {\n"
      "  local -a commands\n"
      "  commands=(\n";
  for (const auto& command : commands) {
    text += fmt::format("    {}\n", ShellQuoted(command.name + ":" + ForZsh(command.summary)));
  }
  text +=
      "  )\n"
      "  if (( CURRENT == 2 )); then\n"
      "    _describe command commands\n"
      "    return\n"
      "  fi\n"
      "  local command=$words[2]\n"
      "  shift words\n"
      "  (( CURRENT-- ))\n"
      "  case $command in\n";
  for (const auto& command : commands) {
    text += fmt::format("    {})\n      _arguments -S", command.name);
    for (const auto& option : command.options) {
      std::string value;
      if (!option.value.empty()) {
        const auto words = option.name == "set" ? SettingNames(command) : option.Choices();
        std::string action = option.TakesFile() ? "_files" : " ";
        if (option.name == "set") {
          action = fmt::format("compadd -S \"\" -- {}", fmt::join(words, " "));
        } else if (!words.empty()) {
          action = fmt::format("({})", fmt::join(words, " "));
        }
        value = fmt::format(":{}:{}", ForZsh(option.name), action);
      }
      const bool again = option.several || option.name == "set";
      for (const auto& spelling : Spellings(option)) {
        text +=
            fmt::format(" \\\n        {}",
                        ShellQuoted(fmt::format(
                            "{}{}[{}]{}", again ? "*" : "", spelling, ForZsh(option.help), value)));
      }
    }
    text += " \\\n        '*:file:_files'\n      ;;\n";
  }
  text +=
      "    help) _describe command commands ;;\n"
      "  esac\n"
      "}\n"
      "_lipoid \"$@\"\n";
  return text;
}

std::string FishScript(std::span<const CommandDescription> commands) {
  std::string text =
      "# fish completion of lipoid; made by lipoid --completion fish\n"
      "complete -c lipoid -n __fish_use_subcommand -f -s V -l version -d 'which lipoid this is'\n";
  for (const auto& command : commands) {
    text += fmt::format("complete -c lipoid -n __fish_use_subcommand -f -a {} -d {}\n",
                        command.name,
                        QuotedForFish(command.summary));
  }
  for (const auto& command : commands) {
    const auto start =
        fmt::format("complete -c lipoid -n '__fish_seen_subcommand_from {}'", command.name);
    for (const auto& option : command.options) {
      std::string line = start;
      if (option.letter != '\0') line += fmt::format(" -s {}", option.letter);
      line += " -l " + option.name;
      if (!option.value.empty()) line += option.TakesFile() ? " -r" : " -x";
      const auto words = option.name == "set" ? SettingNames(command) : option.Choices();
      if (!words.empty()) line += " -a " + QuotedForFish(fmt::format("{}", fmt::join(words, " ")));
      text += line + " -d " + QuotedForFish(option.help) + "\n";
    }
  }
  return text;
}

}  // namespace

std::string CompletionScript(std::string_view shell, std::span<const CommandDescription> commands) {
  if (shell == "bash") return BashScript(commands);
  if (shell == "zsh") return ZshScript(commands);
  if (shell == "fish") return FishScript(commands);
  throw OptionError(UnknownName("shell", std::string(shell), {"bash", "zsh", "fish"}));
}

}  // namespace lipoid::cli
