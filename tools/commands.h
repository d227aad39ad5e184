#pragma once

/// @file
/// The only list of commands. Help, dispatch and messages are made from it. To add one: a file in
/// tools/commands/, a declaration and a row here.

#include <algorithm>

#include "tools/cli/command_line.h"

namespace lipoid {

cli::ExitCode List(cli::CommandLine& line);

inline constexpr cli::Command kCommands[] = {
    {"list", "what lipoid knows by name: cells", &List},
};
static_assert(std::is_sorted(std::begin(kCommands),
                             std::end(kCommands),
                             [](const auto& a, const auto& b) { return a.name < b.name; }));

}  // namespace lipoid
