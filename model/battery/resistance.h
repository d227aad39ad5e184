#pragma once

/// @file
/// A resistance that is constant or depends on the state of charge: straight lines between nodes,
/// constant beyond them. T is the type of the resistances (double, or an automatic-differentiation
/// scalar). Tests: tests/model/battery/resistance_test.cc.

#include <vector>

#include "model/battery/soc_table.h"

namespace lipoid {

template <class T>
struct Resistance {
  std::vector<double> soc;                ///< strictly increasing; empty when constant
  std::vector<T> resistance_Ohm{T(0.0)};  ///< one value when constant, else one per node; >= 0

  Resistance() = default;
  Resistance(const T& constant) : resistance_Ohm{constant} {}  // NOLINT: a number is a resistance
  Resistance(std::vector<double> nodes, std::vector<T> values)
      : soc(std::move(nodes)), resistance_Ohm(std::move(values)) {}

  [[nodiscard]] bool constant() const { return soc.empty(); }

  void Scale(const T& factor) {
    for (T& r_Ohm : resistance_Ohm) r_Ohm *= factor;
  }

  /// r(A).
  [[nodiscard]] T operator()(const T& at) const { return OverSoc(soc, resistance_Ohm, at); }
};

}  // namespace lipoid
