#pragma once

/// @file
/// "Did you mean": the nearest of a list of names. Tests: tests/tools/cli_test.cc.

#include <string>
#include <string_view>
#include <vector>

namespace lipoid::cli {

/// The known name with the fewest edits (insert, delete, replace, swap neighbours) from `typed`;
/// empty where none is near.
[[nodiscard]] std::string Nearest(std::string_view typed, const std::vector<std::string>& known);

/// "unknown command 'lst'. Did you mean 'list'? Known: ...".
[[nodiscard]] std::string UnknownName(std::string_view what,
                                      std::string_view typed,
                                      const std::vector<std::string>& known);

}  // namespace lipoid::cli
