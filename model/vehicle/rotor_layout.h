#pragma once

/// @file
/// Where the rotors of a vehicle stand and which way they turn: one table with one row for each
/// layout. docs/vehicles.md draws them. Tests: tests/model/vehicle/rotor_layout_test.cc.
///
/// Rotors are numbered clockwise seen from above, from the nose on: the first of a quad-x stands
/// front right, the first of a quad-plus ahead. In coaxial layouts a lower rotor follows its upper
/// one. x points forward, y to the right.

#include <array>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>

namespace lipoid {

enum class RotorLayout { kQuadX, kQuadPlus, kHexaX, kHexaPlus, kOctoX, kOctoPlus, kY6, kX8 };

constexpr std::array<std::pair<RotorLayout, std::string_view>, 8> OptionNames(RotorLayout) {
  return {{{RotorLayout::kQuadX, "quad-x"},
           {RotorLayout::kQuadPlus, "quad-plus"},
           {RotorLayout::kHexaX, "hexa-x"},
           {RotorLayout::kHexaPlus, "hexa-plus"},
           {RotorLayout::kOctoX, "octo-x"},
           {RotorLayout::kOctoPlus, "octo-plus"},
           {RotorLayout::kY6, "y6"},
           {RotorLayout::kX8, "x8"}}};
}

inline constexpr std::size_t kMostRotors = 8;

struct Rotor {
  double ahead = 0.0;    ///< cosine of its angle from the nose: x over the length of the arm
  double right = 0.0;    ///< sine of it: y over the length of the arm
  double turning = 1.0;  ///< 1: turns as the first rotor does, -1: the other way
  bool lower = false;    ///< works in the stream of the rotor above it
};

/// The rotors of a layout, in their order.
[[nodiscard]] std::span<const Rotor> RotorsOf(RotorLayout layout);

}  // namespace lipoid
