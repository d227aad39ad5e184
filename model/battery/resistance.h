#pragma once

/// @file
/// A resistance that is constant or depends on the state of charge: straight lines between nodes,
/// constant beyond them. T is the type of the resistances (double, or an automatic-differentiation
/// scalar). Tests: tests/model/battery/resistance_test.cc.

#include <algorithm>
#include <vector>

#include "model/battery/exact_hold.h"

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

  /// r(A).
  [[nodiscard]] T operator()(const T& at) const {
    if (constant()) return resistance_Ohm[0];
    const double a = ScalarPart(at);
    if (!(a > soc.front())) return resistance_Ohm.front();
    if (a >= soc.back()) return resistance_Ohm.back();
    const auto above =
        static_cast<std::size_t>(std::upper_bound(soc.begin(), soc.end(), a) - soc.begin());
    const T share = (at - T(soc[above - 1])) * (1.0 / (soc[above] - soc[above - 1]));
    return resistance_Ohm[above - 1] + share * (resistance_Ohm[above] - resistance_Ohm[above - 1]);
  }
};

}  // namespace lipoid
