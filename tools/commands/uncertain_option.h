#pragma once

/// @file
/// A number on the command line that may carry its standard error: 0.8 or 0.8+-0.05.

#include <string>

#include "model/core/options.h"
#include "model/statistics/uncertain.h"
#include "tools/cli/command_line.h"

namespace lipoid {

/// What stands for such a value in help.
inline constexpr std::string_view kUncertainWord = "X[+-SE]";

/// Reads "X" or "X+-SE" (or with the sign for plus and minus), each in percent where it ends in a
/// percent sign. OptionError names the option, what is wrong and the valid range of X.
[[nodiscard]] Uncertain ReadUncertain(const std::string& option,
                                      const std::string& text,
                                      const Range& valid);

}  // namespace lipoid
