#pragma once

/// @file
/// What the page may ask of lipoid: a command with options, as JSON
///
///   {"command": "identify", "options": [["method", "staged"], ["fix", "r_s=0.01"]]}
///   {"command": "fly", "maneuver": "square", "cell_of": 3, "options": [["compensate"]]}
///   {"command": "validate", "cell_of": 3, "logs": [1, 2], "options": []}
///
/// Only options of a list are taken, and none of these names a file, nor does what --set may set:
/// whoever has the address can make lipoid read what was dropped on the page, and nothing else.
/// Whether a value is right is for the command itself to say. Tests: tests/tools/serve_test.py.

#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/core/json.h"
#include "tools/cli/command_description.h"

namespace lipoid {

struct JobRequest {
  std::string command;
  std::vector<std::string> options;  ///< "--method=staged"
  std::string maneuver;              ///< fly
  std::string cell;                  ///< fly: a shipped cell, where it is not that of a job
  std::optional<int> cell_of;        ///< fly and validate: the job whose cell it is
  std::vector<int> logs;             ///< validate
  Json told;                         ///< the options as asked, for the page
};

/// The commands and, of each, the options that the page offers. What they are called and what they
/// take is for `all` to say, the descriptions of all commands.
class JobOptions {
 public:
  explicit JobOptions(const std::vector<cli::CommandDescription>& all);

  /// HttpError 400 with a sentence where it is not as above.
  [[nodiscard]] JobRequest Read(const Json& asked) const;
  /// The same as data for the page: names, words of help, choices, defaults, settings.
  [[nodiscard]] Json ToJson() const;
  /// Whether a command can write a page (--report).
  [[nodiscard]] bool Reports(std::string_view command) const;

 private:
  [[nodiscard]] const cli::CommandDescription* Find(std::string_view command) const;

  std::vector<cli::CommandDescription> commands_;  // with the allowed options alone
  std::vector<std::string> reporting_;
};

/// Parses what a client sent; HttpError 400 where it is no JSON object.
[[nodiscard]] Json ParsedBody(const std::string& text);

}  // namespace lipoid
