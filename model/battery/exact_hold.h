#pragma once

/// @file
/// Exact zero-order hold of a first-order mode x' = -rate x + i over a step of constant i:
///
///   x+ = decay x + gain i,   decay = e^{-rate dt},   gain = (1 - e^{-rate dt})/rate
///
/// Every state of the cell is such a mode: the unavailable charges of (4.46) with rate beta² m²,
/// the delivered charge with rate 0, the branches of (4.50) with rate 1/(r c) and the drive r i.
/// Both coefficients are written with phi(z) = (e^z - 1)/z, so that neither they nor their
/// derivatives lose digits when rate dt is tiny (beta = 0.01 sampled at 10 ms has rate dt = 1e-6).
/// T may be double or any automatic-differentiation scalar with +, - and * by double.
/// Tests: tests/model/battery/exact_hold_test.cc.

#include <cmath>

namespace lipoid {

/// The double inside an automatic-differentiation scalar: overload it for others (Jets carry it in
/// `.a`).
inline double ScalarPart(double x) { return x; }
template <class T>
auto ScalarPart(const T& x) -> decltype(double(x.a)) {
  return x.a;
}

/// f(x) of a scalar type of which only the double function and its slope are known: exact to first
/// order, which is all that first derivatives need.
template <class T>
T Linearized(double value, double slope, const T& x) {
  if constexpr (requires(T y) { y.v *= slope; }) {  // a Jet
    T y(x);
    y.a = value;
    y.v *= slope;
    return y;
  } else {
    return T(value) + slope * (x - T(ScalarPart(x)));
  }
}
inline double Linearized(double value, double, double) { return value; }

/// phi(z) = (e^z - 1)/z = sum_k z^k/(k+1)!, and phi(0) = 1.
inline double Phi(double z) { return z == 0.0 ? 1.0 : std::expm1(z) / z; }

/// phi'(z) = (e^z (z - 1) + 1)/z², by its series where that form cancels.
inline double PhiSlope(double z) {
  if (std::abs(z) >= 1.0) return (std::exp(z) * (z - 1.0) + 1.0) / (z * z);
  // sum_j (j+1) z^j/(j+2)!; the term after the 17th is below 1e-16 for |z| < 1, and often so is an earlier one.
  double term = 0.5;  // z^j/(j+2)!
  double sum = 0.0;
  for (int j = 0; j < 17 && std::abs(term) > 1e-20; ++j) {
    sum += (j + 1) * term;
    term *= z / (j + 3);
  }
  return sum;
}

/// To be added to a mode in every step: nothing beside any charge or voltage, yet it keeps a mode
/// that dies out in a long rest from ending in denormal numbers, with which processors are ten
/// times slower.
inline constexpr double kAlive = 1e-200;

template <class T>
struct HoldCoefficients {
  T decay;
  T gain;  ///< s
};

/// Coefficients of a step of dt_s >= 0 for a mode of rate >= 0 in 1/s (infinite: the mode is at
/// rest).
template <class T>
HoldCoefficients<T> ExactHold(const T& rate_per_s, double dt_s) {
  if (std::isinf(ScalarPart(rate_per_s))) return {T(0.0), T(0.0)};
  const T z = -dt_s * rate_per_s;
  const double z0 = ScalarPart(z);
  const double decay = std::exp(z0);
  return {Linearized(decay, decay, z), dt_s * Linearized(Phi(z0), PhiSlope(z0), z)};
}

}  // namespace lipoid
