#pragma once

/// @file
/// The temperature of a cell as one lump that its own heat warms and its surroundings cool
/// (docs/theory.md, "Temperature"; Bernardi, Pawlikowski and Newman, J. Electrochem. Soc. 132
/// (1985) 5).
///
///   C dT/dt = q - (T - T_ambient)/R_th
///   q       = i (v_oc - v_b) - i T dv_oc/dT
///
/// with the discharge current i > 0. v_oc is that of the charge balance, f(1 - sigma_d/alpha): the
/// energy of the cell is a function of the charge that has left it, so that what leaves it is
/// electrical work or heat. A step is exact while q is constant. T as in cell_model.h. Tests:
/// tests/model/battery/temperature_test.cc.

#include <cmath>

#include "model/battery/exact_hold.h"

namespace lipoid {

template <class T>
struct HeatBalance {
  T heat_capacity_J_per_K = T(0.0);       ///< C > 0
  T thermal_resistance_K_per_W = T(0.0);  ///< R_th > 0, from the cell to its surroundings

  /// The temperature after heat_W has been released for dt_s.
  [[nodiscard]] T After(const T& temperature_K,
                        const T& heat_W,
                        const T& ambient_K,
                        double dt_s) const {
    const T settled_K = ambient_K + heat_W * thermal_resistance_K_per_W;
    const auto hold =
        ExactHold(T(1.0) / (heat_capacity_J_per_K * thermal_resistance_K_per_W), dt_s);
    return settled_K + hold.decay * (temperature_K - settled_K);
  }
};

}  // namespace lipoid
