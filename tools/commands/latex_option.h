#pragma once

/// @file
/// --latex FILE: the tables that a command prints, for a paper.

#include <string>
#include <string_view>

#include "tools/cli/command_line.h"
#include "tools/cli/text_table.h"

namespace lipoid {

class LatexOption {
 public:
  void AddTo(cli::CommandLine& line);
  /// Keeps a table for the file, and is the table as text.
  [[nodiscard]] std::string Table(const cli::TextTable& table, std::string_view caption);
  /// Writes the tables, where the option was given: which lipoid, which command, what they need.
  void Write(const cli::CommandLine& line) const;

 private:
  std::string file_;
  std::string tables_;
};

}  // namespace lipoid
