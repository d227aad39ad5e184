#pragma once

/// @file
/// Numbers that have two names on a command line, an option and --set.

#include "identify/identify_request.h"
#include "identify/stages/staged_request.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// After Parse(), before Resolve(): OptionError where the two say different things, whichever
/// stands first.
void CheckSaidOnce(const cli::CommandLine& line, const StagedRequest& request);
void CheckSaidOnce(const cli::CommandLine& line, const IdentifyRequest& request);

}  // namespace lipoid
