#pragma once

/// @file
/// How a resistance or a time constant changes with the temperature of the cell: the law of
/// Arrhenius about a reference temperature (docs/theory.md, "Temperature").
///
///   f(T) = exp(E/R (1/T - 1/T_ref)),   f(T_ref) = 1
///
/// E > 0: the quantity grows in the cold. Temperatures are in K, energies in J/mol, and
/// R = 8.314462618 J/(mol K) (CODATA 2018, exact). Tests: tests/model/battery/temperature_test.cc.

#include <cmath>

#include "model/battery/exact_hold.h"

namespace lipoid {

inline constexpr double kGasConstant_J_per_mol_K = 8.314462618;
inline constexpr double kZeroCelsius_K = 273.15;
/// 25 degC, at which cells are compared where nothing else is said.
inline constexpr double kUsual_K = 25.0 + kZeroCelsius_K;

/// Without the roundings of the sum that made the kelvin: 25 degC and not 25.000000000000057.
[[nodiscard]] inline double CelsiusOf(double temperature_K) {
  return std::round((temperature_K - kZeroCelsius_K) * 1e9) * 1e-9;
}

/// f(T).
template <class T>
[[nodiscard]] T ArrheniusFactor(const T& energy_J_per_mol,
                                const T& temperature_K,
                                double reference_K) {
  const double at_K = ScalarPart(temperature_K);
  const T inverse = Linearized(1.0 / at_K, -1.0 / (at_K * at_K), temperature_K);
  const T z =
      energy_J_per_mol * (inverse - T(1.0 / reference_K)) * (1.0 / kGasConstant_J_per_mol_K);
  const double f = std::exp(ScalarPart(z));
  return Linearized(f, f, z);
}

}  // namespace lipoid
