#pragma once

/// @file
/// A choice among names, for tests of what reads options.

#include <array>
#include <string_view>
#include <utility>

namespace lipoid::test {

enum class Colour { kRed, kBlue };
constexpr std::array<std::pair<Colour, std::string_view>, 2> OptionNames(Colour) {
  return {{{Colour::kRed, "red"}, {Colour::kBlue, "blue"}}};
}

}  // namespace lipoid::test
