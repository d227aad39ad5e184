#pragma once

/// @file
/// Complementary filter for the attitude: the gyro, integrated by rho' = S(rho) Omega (3.6), is
/// drawn towards the tilt that the accelerometer shows as long as that shows little but gravity:
///
///   |f| within a band around g:   roll += W (atan2(-f_y, -f_z) - roll)
///                                 pitch += W (atan2(f_x, |f_y, f_z|) - pitch)
///
/// A weight W per step of dt makes this a time constant of dt/W, and a gyro bias b that is left
/// becomes a tilt of b dt (1 - W)/W. Nothing corrects the yaw: it drifts by the bias of the gyro.
///
/// A quadrotor without drag accelerates where it leans: in flight f is always along its own z axis
/// and the "tilt" shown is zero. That draws a tilt that is held towards level with the time
/// constant above: a limit of every such filter, not of this code. Tests:
/// tests/model/control/attitude_filter_test.cc.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/vehicle/rigid_body.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

class AttitudeFilter {
 public:
  AttitudeFilter(double accelerometer_weight, double gravity_band_m_per_s2, double step_s)
      : weight_(accelerometer_weight), band_m_per_s2_(gravity_band_m_per_s2), step_s_(step_s) {}

  void Reset(const Triple<double>& angles_rad, const Triple<double>& body_rates_rad_per_s) {
    angles_rad_ = angles_rad;
    attitude_ = Attitude<double>(angles_rad);
    rates_rad_per_s_ = body_rates_rad_per_s;
  }

  /// Body rates and specific force (body axes) at the end of the step.
  void Step(const Triple<double>& rates_rad_per_s, const Triple<double>& force_m_per_s2) {
    // Heun: the rates at both ends are known.
    const Triple<double> before = attitude_.AngleRates(rates_rad_per_s_);
    Triple<double> guess;
    for (std::size_t k = 0; k < 3; ++k) guess[k] = angles_rad_[k] + step_s_ * before[k];
    guess[1] = AwayFromThePole(guess[1]);
    const Triple<double> after = Attitude<double>(guess).AngleRates(rates_rad_per_s);
    for (std::size_t k = 0; k < 3; ++k) angles_rad_[k] += 0.5 * step_s_ * (before[k] + after[k]);
    rates_rad_per_s_ = rates_rad_per_s;

    const auto& f = force_m_per_s2;
    const double across = std::hypot(f[1], f[2]);
    if (std::abs(std::hypot(f[0], across) - kGravity_m_per_s2) <= band_m_per_s2_) {
      const double roll_error = std::atan2(-f[1], -f[2]) - angles_rad_[0];
      angles_rad_[0] += weight_ * std::remainder(roll_error, 2.0 * std::numbers::pi);
      angles_rad_[1] += weight_ * (std::atan2(f[0], across) - angles_rad_[1]);
    }
    angles_rad_[1] = AwayFromThePole(angles_rad_[1]);
    attitude_ = Attitude<double>(angles_rad_);
  }

  [[nodiscard]] const Triple<double>& angles_rad() const { return angles_rad_; }
  [[nodiscard]] const Attitude<double>& attitude() const { return attitude_; }

 private:
  static double AwayFromThePole(double pitch_rad) {
    return std::clamp(pitch_rad, -kGimbalLock_rad, kGimbalLock_rad);
  }

  double weight_;
  double band_m_per_s2_;
  double step_s_;
  Triple<double> angles_rad_{};
  Triple<double> rates_rad_per_s_{};
  Attitude<double> attitude_{angles_rad_};
};

}  // namespace lipoid
