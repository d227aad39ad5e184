#pragma once

/// @file
/// `lipoid COMMAND --help`, from what the command declared of itself.
/// Tests: tests/tools/cli_test.cc.

#include <string>

#include "tools/cli/command_description.h"

namespace lipoid::cli {

/// Wrapped to the width of a screen; common options and those of --set come last.
[[nodiscard]] std::string HelpText(const CommandDescription& command);

}  // namespace lipoid::cli
