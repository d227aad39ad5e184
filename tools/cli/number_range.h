#pragma once

/// @file
/// FIRST:STEP:LAST on the command line.

#include <string>
#include <vector>

#include "model/core/options.h"

namespace lipoid {

/// The numbers of "0.8:0.01:1" (the last one included where the steps hit it), or of "0.9", each in
/// percent where it ends in a percent sign. All in the valid range. OptionError names the option and
/// what is wrong.
[[nodiscard]] std::vector<double> ReadRange(const std::string& option,
                                            const std::string& text,
                                            const Range& valid);

}  // namespace lipoid
