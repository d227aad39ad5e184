#pragma once

/// @file
/// NAME=VALUE on the command line, for --with, --fix, --start and --bounds.

#include <string>
#include <utility>
#include <vector>

namespace lipoid {

/// "r_1=0.03,c_1=1500" or one of them per text, in the order written. OptionError names the option
/// and the piece that is neither.
[[nodiscard]] std::vector<std::pair<std::string, double>> ParseAssignments(
    const std::string& option, const std::vector<std::string>& texts);

/// "beta=0.1,0.5": NAME=LOW,HIGH, one per text.
[[nodiscard]] std::vector<std::pair<std::string, std::pair<double, double>>> ParseRanges(
    const std::string& option, const std::vector<std::string>& texts);

}  // namespace lipoid
