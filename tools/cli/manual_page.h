#pragma once

/// @file
/// The manual page lipoid(1), made from what the commands declare. Tests:
/// tests/tools/completion_test.cc.

#include <span>
#include <string>

#include "tools/cli/command_description.h"

namespace lipoid::cli {

/// The page as roff (the macros of man(7)).
[[nodiscard]] std::string ManualPage(std::span<const CommandDescription> commands);

}  // namespace lipoid::cli
