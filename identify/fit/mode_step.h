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

/// d gain/d rate over dt² of a mode with z = rate dt, fall = 1 - e^-z and decay = 1 - fall:
/// (z e^-z - (1 - e^-z))/z² = -sum_k (-z)^k/(k! (k + 2)). The closed form cancels where z is small, and
/// nine terms are exact to 1e-16 there.
inline double GainCurve(double z, double fall, double decay) {
  constexpr double kSmall = 0.05;
  if (z >= kSmall) return (z * decay - fall) / (z * z);
  constexpr double kTerms[] = {1.0 / 2.0,
                               -1.0 / 3.0,
                               1.0 / 8.0,
                               -1.0 / 30.0,
                               1.0 / 144.0,
                               -1.0 / 840.0,
                               1.0 / 5760.0,
                               -1.0 / 45360.0,
                               1.0 / 403200.0};
  double sum = 0.0;
  for (int k = 8; k >= 0; --k) sum = sum * z + kTerms[k];
  return -sum;
}

/// A mode of the diffusion, sigma_um of (4.46), whose rate is beta² times mm = m²; slopes in beta > 0.
/// fall = 1 - e^(-mm beta² dt) is given, for modes side by side share an exponential. The gain is in
/// seconds. Equal to ExactHold() and its derivative; slopes are 0 where they are not asked for.
inline ModeStep DiffusionStep(
    double mm, double beta_per_sqrt_s, double dt_s, double fall, bool slopes = true) {
  const double rate_slope = 2.0 * mm * beta_per_sqrt_s;
  const double z = mm * beta_per_sqrt_s * beta_per_sqrt_s * dt_s;
  const double decay = 1.0 - fall;
  const double gain = z < 1e-300 ? dt_s : dt_s * (fall / z);  // (4.46)
  if (!slopes) return {decay, gain, 0.0, 0.0};
  return {decay,
          gain,
          -decay * dt_s * rate_slope,
          dt_s * dt_s * GainCurve(z, fall, decay) * rate_slope};
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

  /// step(k, length) gives that of mode k.
  template <class Lengths, class Step>
  void Set(Eigen::Index modes, const Lengths& lengths_s, Step&& step) {
    const auto columns = static_cast<Eigen::Index>(lengths_s.size());
    Resize(modes, columns);
    for (Eigen::Index c = 0; c < columns; ++c) {
      for (Eigen::Index k = 0; k < modes; ++k)
        Put(k, c, step(k, lengths_s[static_cast<std::size_t>(c)]));
    }
  }

  /// Column c: the modes 1, 2, ... of the diffusion over one length, in one exponential for all. With
  /// f_m = 1 - q^(m²) and o_m = 1 - q^(2m - 1), q = e^(-beta² dt),
  ///
  ///   o_m+1 = o_m + (1 - o_m) f_2',   f_m+1 = f_m + (1 - f_m) o_m+1,   f_2' = 1 - q²
  ///
  /// in which nothing cancels.
  void SetDiffusion(Eigen::Index c, double beta_per_sqrt_s, double dt_s, bool slopes = true) {
    double fall = -std::expm1(-beta_per_sqrt_s * beta_per_sqrt_s * dt_s);
    double odd = fall;
    const double two = fall * (2.0 - fall);
    for (Eigen::Index k = 0; k < decay.rows(); ++k) {
      const auto m = static_cast<double>(k + 1);
      Put(k, c, DiffusionStep(m * m, beta_per_sqrt_s, dt_s, fall, slopes));
      odd += (1.0 - odd) * two;
      fall += (1.0 - fall) * odd;
    }
  }

  void Resize(Eigen::Index modes, Eigen::Index columns) {
    for (Eigen::ArrayXXd* v : {&decay, &gain, &decay_slope, &gain_slope}) v->resize(modes, columns);
  }
  void Put(Eigen::Index k, Eigen::Index c, const ModeStep& one) {
    decay(k, c) = one.decay;
    gain(k, c) = one.gain;
    decay_slope(k, c) = one.decay_slope;
    gain_slope(k, c) = one.gain_slope;
  }
};

}  // namespace lipoid
