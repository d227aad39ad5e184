#pragma once

/// @file
/// "Did you mean": the nearest of a list of names. Tests: tests/model/core/nearest_name_test.cc.

#include <string>
#include <string_view>
#include <vector>

#include "model/core/errors.h"

namespace lipoid {

/// The known name with the fewest edits (insert, delete, replace, swap neighbours) from `typed`;
/// empty where none is near.
[[nodiscard]] std::string Nearest(std::string_view typed, const std::vector<std::string>& known);

/// " Did you mean 'list'?", to be put behind a sentence; "" where no known name is near.
[[nodiscard]] std::string DidYouMean(std::string_view typed, const std::vector<std::string>& known);

/// "; is it 'weight'?", to be put behind what was found; "" where no known key is near.
/// Of one or two letters every other is near: none is named.
[[nodiscard]] std::string NearKey(std::string_view typed, const std::vector<std::string>& known);

/// "unknown command 'lst'. Did you mean 'list'? Known: ...".
[[nodiscard]] std::string UnknownName(std::string_view what,
                                      std::string_view typed,
                                      const std::vector<std::string>& known);

template <class Rows>
[[nodiscard]] std::vector<std::string> NamesOf(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) names.emplace_back(row.name);
  return names;
}

/// The row of that name; OptionError that names the nearest where there is none.
template <class Rows>
[[nodiscard]] const auto& FindNamed(std::string_view what,
                                    std::string_view name,
                                    const Rows& rows) {
  for (const auto& row : rows) {
    if (row.name == name) return row;
  }
  throw OptionError(UnknownName(what, name, NamesOf(rows)));
}

}  // namespace lipoid
