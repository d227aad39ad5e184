#pragma once

/// @file
/// Charge-transfer kinetics: a drop that grows with the logarithm of a large current
/// (docs/theory.md, "Two terms beyond the thesis").
///
///   v_ct = r_ct(A) i_0 asinh(i/i_0)
///
/// r_ct is its slope at i = 0; it follows the current at once. T as in cell_model.h. Tests:
/// tests/model/battery/charge_transfer_test.cc.

#include <cmath>

#include "model/battery/exact_hold.h"
#include "model/battery/resistance.h"

namespace lipoid {

template <class T>
struct ChargeTransfer {
  T current_A = T(0.0);          ///< i_0 > 0, where the drop begins to bend
  Resistance<T> resistance_Ohm;  ///< r_ct(A)

  /// v_ct.
  [[nodiscard]] T Drop(const T& soc, const T& through_A) const {
    const T x = through_A / current_A;
    const double x0 = ScalarPart(x);
    return resistance_Ohm(soc) * current_A *
           Linearized(std::asinh(x0), 1.0 / std::sqrt(1.0 + x0 * x0), x);
  }
};

/// dv_ct/di at this A.
[[nodiscard]] inline double SlopeOfDrop(const ChargeTransfer<double>& term,
                                        double soc,
                                        double through_A) {
  const double x = through_A / term.current_A;
  return term.resistance_Ohm(soc) / std::sqrt(1.0 + x * x);
}

}  // namespace lipoid
