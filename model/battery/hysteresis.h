#pragma once

/// @file
/// Hysteresis of the open-circuit voltage: after charging a cell rests higher than after
/// discharging (docs/theory.md, "Hysteresis"; G. L. Plett, J. Power Sources 134 (2004) 262, its
/// one-state model).
///
///   h' = -(gamma |i|/alpha) (h + sign i),   v_oc,h = f(A) + M(A) h
///
/// Discharge is i > 0 and drives h towards -1, charge towards 1; at rest h stays. gamma is the
/// number of e-folds of h over the whole charge alpha. f(A) lies half-way between the two branches.
/// A step of constant current is exact. T as in cell_model.h. Tests:
/// tests/model/battery/hysteresis_test.cc.

#include <cmath>
#include <vector>

#include "model/battery/exact_hold.h"
#include "model/battery/soc_table.h"

namespace lipoid {

template <class T>
struct Hysteresis {
  T folds = T(0.0);               ///< gamma > 0
  std::vector<double> soc;        ///< strictly increasing; empty when constant
  std::vector<T> half_V{T(0.0)};  ///< M(A) >= 0: half of what charge and discharge differ by

  /// h after `charge_C`, of one sign, has left a cell of alpha_C.
  [[nodiscard]] T After(const T& h, const T& charge_C, const T& alpha_C) const {
    const double sign = ScalarPart(charge_C) > 0.0 ? 1.0 : ScalarPart(charge_C) < 0.0 ? -1.0 : 0.0;
    const T z = (-sign) * (folds * charge_C / alpha_C);
    const double decay = std::exp(ScalarPart(z));
    return Linearized(decay, decay, z) * (h + T(sign)) - T(sign);
  }
  /// M(A) h.
  [[nodiscard]] T Voltage(const T& soc_now, const T& h) const {
    return OverSoc(soc, half_V, soc_now) * h;
  }
  /// Where a cell begins whose past is not told: full, it was charged; else it was discharged.
  [[nodiscard]] static T Start(const T& soc_now) {
    return T(ScalarPart(soc_now) < 1.0 ? -1.0 : 1.0);
  }
};

}  // namespace lipoid
