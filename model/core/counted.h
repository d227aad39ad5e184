#pragma once

/// @file
/// A number of things for people. Tests: tests/model/core/counted_test.cc.

#include <fmt/format.h>

#include <string>
#include <string_view>

namespace lipoid {

/// "1 row", "2 rows".
[[nodiscard]] inline std::string Counted(auto count, std::string_view thing) {
  return fmt::format("{} {}{}", count, thing, count == 1 ? "" : "s");
}

}  // namespace lipoid
