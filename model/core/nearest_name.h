#pragma once

/// @file
/// "Did you mean": the nearest of a list of names. Tests: tests/model/core/nearest_name_test.cc.

#include <string>
#include <string_view>
#include <vector>

namespace lipoid {

/// The known name with the fewest edits (insert, delete, replace, swap neighbours) from `typed`;
/// empty where none is near.
[[nodiscard]] std::string Nearest(std::string_view typed, const std::vector<std::string>& known);

/// " Did you mean 'list'?", to be put behind a sentence; "" where no known name is near.
[[nodiscard]] std::string DidYouMean(std::string_view typed, const std::vector<std::string>& known);

/// "unknown command 'lst'. Did you mean 'list'? Known: ...".
[[nodiscard]] std::string UnknownName(std::string_view what,
                                      std::string_view typed,
                                      const std::vector<std::string>& known);

}  // namespace lipoid
