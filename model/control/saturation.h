#pragma once

/// @file
/// What to do when motors cannot follow: torque before thrust. A lost torque stays as a rate that
/// weak attitude gains need seconds to brake, lost thrust is back in the next step. And the
/// anti-windup rule that goes with it. Tests: tests/model/control/saturation_test.cc.

#include <algorithm>

#include "model/battery/exact_hold.h"

namespace lipoid {

/// Moves the squares of the commanded speeds together into [0, limit]; only where they are further
/// apart than that the differences, which are the torques, shrink. False: nothing was to be done.
/// T is double or an automatic-differentiation scalar, limit > 0.
template <class Squares>
bool Desaturate(Squares& squares, double limit) {
  using T = typename Squares::value_type;
  const auto less = [](const T& a, const T& b) { return ScalarPart(a) < ScalarPart(b); };
  const auto [low, high] = std::minmax_element(squares.begin(), squares.end(), less);
  const T least = *low;
  const T most = *high;
  if (ScalarPart(least) >= 0.0 && ScalarPart(most) <= limit) return false;
  const T middle = 0.5 * (least + most);
  T reach = 0.5 * (most - least);
  T share(1.0);
  if (2.0 * ScalarPart(reach) > limit) {
    share = T(0.5 * limit) / reach;
    reach = T(0.5 * limit);
  }
  T centre = middle;
  if (ScalarPart(middle) < ScalarPart(reach)) centre = reach;
  if (ScalarPart(middle) > limit - ScalarPart(reach)) centre = T(limit) - reach;
  for (T& square : squares) {
    square = centre + share * (square - middle);
    if (ScalarPart(square) < 0.0) square = T(0.0);  // by rounding only
    if (ScalarPart(square) > limit) square = T(limit);
  }
  return true;
}

/// While a motor saturates, an integral may shrink but not grow.
template <class T>
bool MayIntegrate(bool saturated, const T& integral, const T& error) {
  return !(saturated && ScalarPart(error) * ScalarPart(integral) > 0.0);
}

}  // namespace lipoid
