#pragma once

/// @file
/// A quantity tabulated over the state of charge: straight lines between nodes, constant beyond
/// them. T is double or an automatic-differentiation scalar. Tests:
/// tests/model/battery/resistance_test.cc, tests/model/battery/temperature_test.cc.

#include <algorithm>
#include <vector>

#include "model/battery/exact_hold.h"

namespace lipoid {

/// The value at this state of charge. Without nodes there is one value, which holds everywhere.
template <class T>
[[nodiscard]] T OverSoc(const std::vector<double>& soc, const std::vector<T>& value, const T& at) {
  if (soc.empty()) return value[0];
  const double a = ScalarPart(at);
  if (!(a > soc.front())) return value.front();
  if (a >= soc.back()) return value.back();
  const auto above =
      static_cast<std::size_t>(std::upper_bound(soc.begin(), soc.end(), a) - soc.begin());
  const T share = (at - T(soc[above - 1])) * (1.0 / (soc[above] - soc[above - 1]));
  return value[above - 1] + share * (value[above] - value[above - 1]);
}

}  // namespace lipoid
