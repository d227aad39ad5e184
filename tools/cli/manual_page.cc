#include "tools/cli/manual_page.h"

#include "model/core/run_record.h"
#include "tools/cli/run.h"

namespace lipoid::cli {
namespace {

// How many bytes come after the first one of a character of UTF-8.
std::size_t FollowingBytes(char first) {
  const auto byte = static_cast<unsigned char>(first);
  return byte >= 0xf0U ? 3 : byte >= 0xe0U ? 2 : byte >= 0xc0U ? 1 : 0;
}

// A line of text that no macro and no escape can arise from.
std::string Roff(std::string_view text) {
  std::string safe;
  for (std::size_t k = 0; k < text.size(); ++k) {
    const char c = text[k];
    if (const std::size_t more = FollowingBytes(c); more > 0 && k + more < text.size()) {
      // troff reads bytes: it has names for what takes several, \[u00B2] for two of them.
      unsigned code = static_cast<unsigned char>(c) & (0x3fU >> more);
      for (std::size_t n = 1; n <= more; ++n)
        code = (code << 6U) | (static_cast<unsigned char>(text[k + n]) & 0x3fU);
      safe += fmt::format("\\[u{:04X}]", code);
      k += more;
    } else if (c == '\\') {
      safe += "\\e";
    } else if (c == '-') {
      safe += "\\-";
    } else if (c == '\'') {
      safe += "\\(aq";
    } else if (c == ',' && k + 1 < text.size() && text[k + 1] != ' ') {
      safe += ",\\:";  // a list of names without blanks may break there
    } else {
      safe += c;
    }
  }
  return safe.starts_with('.') ? "\\&" + safe : safe;
}

void AddItem(std::string& text, const std::string& left, const std::string& help) {
  text += fmt::format(".TP\n.B {}\n{}\n", Roff(left), Roff(help));
}

void AddOption(std::string& text, const DescribedOption& option) {
  AddItem(text, option.ShownWithValue(), option.Help(true));
}

}  // namespace

std::string ManualPage(std::span<const CommandDescription> commands) {
  std::string text = fmt::format(
      ".TH LIPOID 1 \"\" \"lipoid {}\" \"User Commands\"\n"
      ".SH NAME\n"
      "lipoid \\- identifies lithium\\-polymer cells from lab logs, and flies the result\n"
      ".SH SYNOPSIS\n"
      ".B lipoid\n"
      "COMMAND [arguments] [options]\n"
      ".SH DESCRIPTION\n"
      "Each command has its section below;\n"
      ".B lipoid COMMAND \\-\\-help\n"
      "prints the same for one command.\n"
      ".B lipoid \\-\\-version\n"
      "says which lipoid this is.\n",
      Version());
  text += ".SH COMMANDS\n";
  for (const auto& command : commands) AddItem(text, command.name, command.summary);
  if (!commands.empty()) {
    text += ".SH COMMON OPTIONS\nEvery command takes these.\n";
    for (const auto& option : commands.front().options) {
      if (option.common) AddOption(text, option);
    }
  }
  for (const auto& command : commands) {
    std::string title = command.name;
    for (char& c : title) c = static_cast<char>(c >= 'a' && c <= 'z' ? c - 'a' + 'A' : c);
    text += fmt::format(".SH {}\n.B lipoid {}\n", Roff(title), Roff(command.name));
    for (const auto& argument : command.arguments) {
      const auto name = argument.name + (argument.several ? "..." : "");
      text += Roff(argument.required ? name : "[" + name + "]") + "\n";
    }
    text += "[options]\n.PP\n" + Roff(command.what) + "\n";
    for (const auto& argument : command.arguments) AddItem(text, argument.name, argument.help);
    for (const auto& option : command.options) {
      if (!option.common) AddOption(text, option);
    }
    if (!command.settings.empty()) text += ".PP\nFor \\-\\-set OPTION=VALUE:\n";
    for (const auto& setting : command.settings) AddItem(text, setting.name, setting.Help());
    text += ".PP\nExamples:\n";
    for (const auto& example : command.examples) {
      text += fmt::format(".PP\n.nf\n.RS\n{}\n.RE\n.fi\n", Roff(example));
    }
  }
  return text + fmt::format(".SH EXIT STATUS\n{}\n", kExitCodes);
}

}  // namespace lipoid::cli
