#pragma once

/// @file
/// A number on the command line that may carry its standard error: 0.8 or 0.8+-0.05. Tests:
/// tests/tools/endurance_test.cc.

#include <string>

#include "model/flight/endurance_request.h"
#include "model/statistics/uncertain.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// What stands for such a value in help.
inline constexpr std::string_view kUncertainWord = "X[+-SE]";

/// Reads "X" or "X+-SE" (or with the sign for plus and minus), by what a percent sign means for the variable.
/// OptionError names the option, what is wrong and the valid range of X.
[[nodiscard]] Uncertain ReadUncertain(const EnduranceVariable& variable, const std::string& text);

}  // namespace lipoid
