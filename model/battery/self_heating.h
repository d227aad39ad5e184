#pragma once

/// @file
/// Self-heating of a cell: a first-order low-pass of the square of the current, the thermal state
/// h, which lowers the series resistance (docs/theory.md, "Two terms beyond the thesis").
///
///   h'    = (i² - h)/tau_h,  h = 0 where the cell is relaxed
///   r_s,h = max(r_s(A) - rho h, kLeastSeriesShare r_s(A))
///
/// The straight line is a law for little warming. Where it would take away more than a resistance
/// can lose by heating, the resistance stays at its least share. T as in cell_model.h. Tests:
/// tests/model/battery/self_heating_test.cc.

#include "model/battery/exact_hold.h"

namespace lipoid {

/// What is left of r_s(A), however warm the cell.
inline constexpr double kLeastSeriesShare = 0.25;

template <class T>
struct SelfHeating {
  T time_constant_s = T(0.0);             ///< tau_h > 0
  T resistance_drop_Ohm_per_A2 = T(0.0);  ///< rho >= 0

  /// The series resistance at this thermal state of a cell that has cold_Ohm where it is relaxed.
  [[nodiscard]] T Warm(const T& cold_Ohm, const T& thermal_state_A2) const {
    const T warm = cold_Ohm - resistance_drop_Ohm_per_A2 * thermal_state_A2;
    const T least = kLeastSeriesShare * cold_Ohm;
    return ScalarPart(warm) < ScalarPart(least) ? least : warm;
  }
};

}  // namespace lipoid
