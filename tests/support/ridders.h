#pragma once

/// @file
/// Derivatives by Ridders' method: central differences of shrinking steps, extrapolated to step
/// zero, kept where two neighbouring extrapolations agree best. Good to 10 digits for smooth
/// functions: an oracle for automatic differentiation that knows nothing of the formula.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lipoid::test {

struct RiddersDerivative {
  double value;
  double error;  ///< estimate
};

/// f'(x) starting from differences over 2 * step.
template <class Function>
RiddersDerivative Ridders(Function&& f, double x, double step) {
  constexpr int kOrders = 12;
  constexpr double kShrink = 1.4;
  std::array<std::array<double, kOrders>, kOrders> a{};
  RiddersDerivative best{0.0, std::numeric_limits<double>::infinity()};
  for (int j = 0; j < kOrders; ++j, step /= kShrink) {
    a[0][j] = (f(x + step) - f(x - step)) / (2.0 * step);
    double factor = kShrink * kShrink;
    for (int k = 1; k <= j; ++k, factor *= kShrink * kShrink) {
      a[k][j] = (factor * a[k - 1][j] - a[k - 1][j - 1]) / (factor - 1.0);
      const double error =
          std::max(std::abs(a[k][j] - a[k - 1][j]), std::abs(a[k][j] - a[k - 1][j - 1]));
      if (error <= best.error) best = {a[k][j], error};
    }
    // Rounding has taken over.
    if (j > 0 && std::abs(a[j][j] - a[j - 1][j - 1]) >= 2.0 * best.error) break;
  }
  return best;
}

}  // namespace lipoid::test
