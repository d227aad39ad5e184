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

#include <optional>
#include <vector>

#include "model/battery/arrhenius.h"
#include "model/battery/heat_balance.h"
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
