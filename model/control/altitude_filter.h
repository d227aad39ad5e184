#pragma once

/// @file
/// Kalman filter for the height: state (z, w), z down, driven by the measured acceleration.
///
///   z += dt w + dt²/2 a,   w += dt a + n,  var n = Q;       measured z + e,  var e = R
///
/// Q is the variance that w gains per step, R that of one reading. The covariance is propagated: it
/// grows while readings are missing. Tests: tests/model/control/altitude_filter_test.cc.

#include <cmath>

namespace lipoid {

class AltitudeFilter {
 public:
  /// Of the errors of z and w.
  struct Covariance {
    double zz = 0.0;
    double zw = 0.0;
    double ww = 0.0;
  };

  AltitudeFilter(double q_m2_per_s2, double r_m2, double step_s)
      : q_(q_m2_per_s2), r_(r_m2), step_s_(step_s) {}

  /// A state that is known exactly.
  void Reset(double down_m, double rate_m_per_s) {
    down_m_ = down_m;
    rate_m_per_s_ = rate_m_per_s;
    p_ = {};
  }
  /// Believes a reading alone, as after a time without any.
  void Restart(double down_m) {
    down_m_ = down_m;
    p_.zz = r_;
    p_.zw = 0.0;
  }

  void Predict(double acceleration_m_per_s2) {
    down_m_ += step_s_ * (rate_m_per_s_ + 0.5 * step_s_ * acceleration_m_per_s2);
    rate_m_per_s_ += step_s_ * acceleration_m_per_s2;
    p_.zz += step_s_ * (2.0 * p_.zw + step_s_ * p_.ww);
    p_.zw += step_s_ * p_.ww;
    p_.ww += q_;
  }

  /// Takes a reading unless it is further than `gate_m` from what is expected, or no number.
  bool Update(double down_m, double gate_m) {
    const double innovation = down_m - down_m_;
    if (!(std::abs(innovation) <= gate_m)) return false;
    const double gain_z = p_.zz / (p_.zz + r_);
    const double gain_w = p_.zw / (p_.zz + r_);
    down_m_ += gain_z * innovation;
    rate_m_per_s_ += gain_w * innovation;
    p_.ww -= gain_w * p_.zw;
    p_.zw *= 1.0 - gain_z;
    p_.zz *= 1.0 - gain_z;
    return true;
  }

  [[nodiscard]] double down_m() const { return down_m_; }
  [[nodiscard]] double rate_m_per_s() const { return rate_m_per_s_; }
  [[nodiscard]] const Covariance& covariance() const { return p_; }

 private:
  double q_;
  double r_;
  double step_s_;
  double down_m_ = 0.0;
  double rate_m_per_s_ = 0.0;
  Covariance p_;
};

}  // namespace lipoid
