#pragma once

/// @file
/// A step of the cell's first-order modes with exact slopes: how decay and gain change with the one
/// parameter that sets the rate of the mode. If p and g are decay and gain,
///
///   x+  = p x  + g i
///   x'+ = p x' + p' x + g' i
///
/// so that a state and its sensitivity come from one pass over a log. Tests:
/// tests/identify/fit/mode_step_test.cc.

#include <Eigen/Core>
#include <cmath>

namespace lipoid {

struct ModeStep {
  double decay, gain, decay_slope, gain_slope;
};

/// Mode m >= 1 of the diffusion, sigma_um of (4.46); slopes in beta > 0. The gain is in seconds.
/// Equal to ExactHold() and its derivative, in one exponential.
inline ModeStep DiffusionStep(int m, double beta_per_sqrt_s, double dt_s) {
  const double mm = static_cast<double>(m) * static_cast<double>(m);
  const double rate_per_s = mm * beta_per_sqrt_s * beta_per_sqrt_s;
  const double rate_slope = 2.0 * mm * beta_per_sqrt_s;
  const double z = rate_per_s * dt_s;
  const double fall = -std::expm1(-z);  // 1 - decay
  const double decay = 1.0 - fall;
  // d gain/d rate = (z e^-z - (1 - e^-z))/rate² = -dt² sum_k (-z)^k/(k! (k + 2)): the closed form
  // cancels where z is small, and nine terms are exact to 1e-16 there.
  constexpr double kSmall = 0.05;
  double curve = 0.0;
  if (z < kSmall) {
    double term = 1.0;
    for (int k = 0; k < 9; ++k) {
      curve -= term / (k + 2);
      term *= -z / (k + 1);
    }
  } else {
    curve = (z * decay - fall) / (z * z);
  }
  const double gain = z < 1e-300 ? dt_s : dt_s * (fall / z);  // (4.46)
  return {decay, gain, -decay * dt_s * rate_slope, dt_s * dt_s * curve * rate_slope};
}

/// A low pass of unit gain, x' = (i - x)/tau: a branch of (4.50) over its resistance. Slopes in tau.
inline ModeStep LowPassStep(double tau_s, double dt_s) {
  const double z = dt_s / tau_s;
  const double gain = -std::expm1(-z);  // (4.50)
  const double slope = (1.0 - gain) * z / tau_s;
  return {1.0 - gain, gain, slope, -slope};
}

/// Steps of several modes side by side, so that they run in vector registers: a row for each mode, a
/// column for each length of a step.
struct ModeSteps {
  Eigen::ArrayXXd decay, gain, decay_slope, gain_slope;

  /// step(k, length) gives that of mode k; a length may be anything that says how long a step is.
  template <class Lengths, class Step>
  void Set(Eigen::Index modes, const Lengths& lengths_s, Step&& step) {
    const auto columns = static_cast<Eigen::Index>(lengths_s.size());
    for (Eigen::ArrayXXd* v : {&decay, &gain, &decay_slope, &gain_slope}) v->resize(modes, columns);
    for (Eigen::Index c = 0; c < columns; ++c) {
      for (Eigen::Index k = 0; k < modes; ++k) {
        const ModeStep one = step(k, lengths_s[static_cast<std::size_t>(c)]);
        decay(k, c) = one.decay;
        gain(k, c) = one.gain;
        decay_slope(k, c) = one.decay_slope;
        gain_slope(k, c) = one.gain_slope;
      }
    }
  }
};

}  // namespace lipoid
