#pragma once

/// @file
/// Numbers that many tests use.

#include <limits>
#include <numbers>

namespace lipoid::test {

inline constexpr double kEpsilon = std::numeric_limits<double>::epsilon();
inline constexpr double kPi = std::numbers::pi;
inline constexpr double kDegree = kPi / 180.0;

inline constexpr double kFlightStep_s = 0.005;  ///< of controllers and simulated flights

/// What tests of all poses and vehicles draw: from where, and how often.
inline constexpr unsigned kDrawSeed = 20261120;
inline constexpr int kPoseDraws = 200;

}  // namespace lipoid::test
