#pragma once

/// @file
/// Numbers that many tests use.

#include <limits>
#include <numbers>

namespace lipoid::test {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;

}  // namespace lipoid::test
