#pragma once

/// @file
/// Completions for shells, made from what the commands declare: commands, options, the choices of
/// an option, the names after --set, and files elsewhere. Tests: tests/tools/completion_test.cc.

#include <span>
#include <string>
#include <string_view>

#include "tools/cli/command_description.h"

namespace lipoid::cli {

/// The script for "bash", "zsh" or "fish"; OptionError for any other shell.
[[nodiscard]] std::string CompletionScript(std::string_view shell,
                                           std::span<const CommandDescription> commands);

}  // namespace lipoid::cli
