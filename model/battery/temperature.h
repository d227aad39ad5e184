#pragma once

/// @file
/// What the temperature of a cell does to it (docs/theory.md, "Temperature"):
///
///   r_s(A, T) = r_s(A) f_s(T),   r_j(A, T) = r_j(A) f_j(T)
///   beta²(T)  = beta²/f_d(T)
///   v_ct(A, T) = (T/T_ref) r_ct(A) i_0 asinh(f_ct(T) i/i_0)
///   v_oc(A, T) = f(A) + (T - T_ref) dv_oc/dT(A)
///
/// Each factor is one of arrhenius.h with an energy of its own. The time constants of the branches
/// stay: pulses from -20 to 25 degC that were left out of a fit say so (docs/joint.md). The drop of charge transfer has the
/// thermal voltage R T/F before it, and its exchange current falls in the cold. T is double or an
/// automatic-differentiation scalar. Tests: tests/model/battery/temperature_test.cc.
///
/// The temperature is that of one lump that its own heat warms and its surroundings cool (Bernardi,
/// Pawlikowski and Newman, J. Electrochem. Soc. 132 (1985) 5):
///
///   C dT/dt = q - (T - T_ambient)/R_th
///   q       = i (v_oc - v_b) - i T dv_oc/dT
///
/// with the discharge current i > 0. v_oc is that of the charge balance, f(1 - sigma_d/alpha): the
/// energy of the cell is a function of the charge that has left it, so that what leaves it is
/// electrical work or heat. A step is exact while q is constant.

#include <optional>
#include <vector>

#include "model/battery/arrhenius.h"
#include "model/battery/exact_hold.h"
#include "model/battery/soc_table.h"

namespace lipoid {

/// dv_oc/dT over the state of charge, in V/K.
///
/// What voltages show of it may hold more than entropy: relaxation that is slower than the rests
/// looks like a lower v_oc in the cold. Where measured temperatures contradict its heat, it is a
/// slope of the voltage alone.
template <class T>
struct EntropySlope {
  std::vector<double> soc;               ///< strictly increasing; empty when constant
  std::vector<T> slope_V_per_K{T(0.0)};  ///< one value when constant, else one per node
  bool reversible_heat = true;           ///< whether i T dv_oc/dT takes part in the heat

  [[nodiscard]] T operator()(const T& at) const { return OverSoc(soc, slope_V_per_K, at); }
};

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

template <class T>
struct TemperatureDependence {
  double reference_K = kUsual_K;  ///< where every factor is 1
  /// Activation energies; of the branches one each.
  T series_J_per_mol = T(0.0);
  std::vector<T> branches_J_per_mol;
  T diffusion_J_per_mol = T(0.0);
  T charge_transfer_J_per_mol = T(0.0);
  std::optional<HeatBalance<T>> heat;  ///< none: the cell has the temperature of its surroundings
  std::optional<EntropySlope<T>> entropy;  ///< none: v_oc(A) does not know the temperature

  [[nodiscard]] T Factor(const T& energy_J_per_mol, const T& temperature_K) const {
    return ArrheniusFactor(energy_J_per_mol, temperature_K, reference_K);
  }
};

}  // namespace lipoid
