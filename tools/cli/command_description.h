#pragma once

/// @file
/// What a command declared of itself, as data: the manual page and the completions of shells are
/// made from it, so that they hold every command and option. Tests: tests/tools/cli_test.cc.

#include <string>
#include <vector>

namespace lipoid::cli {

struct DescribedOption {
  std::string name;  ///< without dashes
  char letter = '\0';
  std::string value;  ///< "FILE", "0 .. 5", "staged | joint"; empty: the option takes none
  std::string default_text;
  std::string help;
  bool several = false;
  bool required = false;
  bool common = false;  ///< to all commands

  /// "-o, --output".
  [[nodiscard]] std::string Shown() const;
  /// "-o, --output CSV": a short word stands beside the name, a list of choices or a range in Help().
  [[nodiscard]] std::string ShownWithValue() const;
  /// "log; 0 .. 5 (default 3)".
  [[nodiscard]] std::string Help(bool say_required = false) const;
  [[nodiscard]] bool TakesFile() const;
  /// "staged", "joint" of "staged | joint"; none where the value is no choice.
  [[nodiscard]] std::vector<std::string> Choices() const;
};

struct CommandDescription {
  struct Argument {
    std::string name;
    std::string help;
    bool several = false;
    bool required = true;
  };
  struct Setting {
    std::string name;  ///< as after --set
    std::string help;
    std::string valid;
    std::string default_text;

    [[nodiscard]] std::string Help() const;
  };

  std::string name;
  std::string summary;  ///< one line
  std::string what;     ///< sentences
  std::vector<std::string> examples;
  std::vector<Argument> arguments;
  std::vector<DescribedOption> options;
  std::vector<Setting> settings;
};

}  // namespace lipoid::cli
