#pragma once

/// @file
/// Kinematics and dynamics of a rigid body in Euler angles, (3.1)-(3.8).
///
/// Inertial axes X, Y, Z with Z down; body axes by yaw, pitch, roll. S has its pole at a pitch of
/// 90 degrees: who integrates stops before (kGimbalLock_rad). T is double or an
/// automatic-differentiation scalar. Tests: tests/model/vehicle/rigid_body_test.cc.

#include <array>
#include <cmath>
#include <numbers>

namespace lipoid {

template <class T>
using Triple = std::array<T, 3>;

/// Beyond this pitch the Euler angles are of no use: half a degree from their pole.
inline constexpr double kGimbalLock_rad = 0.5 * std::numbers::pi - 0.0087;

/// Sines and cosines of roll, pitch and yaw, computed once for everything that needs them.
template <class T>
struct Attitude {
  T sin_roll, cos_roll, sin_pitch, cos_pitch, sin_yaw, cos_yaw;

  Attitude(const T& roll, const T& pitch, const T& yaw) {
    using std::cos;
    using std::sin;
    sin_roll = sin(roll);
    cos_roll = cos(roll);
    sin_pitch = sin(pitch);
    cos_pitch = cos(pitch);
    sin_yaw = sin(yaw);
    cos_yaw = cos(yaw);
  }
  explicit Attitude(const Triple<T>& angles) : Attitude(angles[0], angles[1], angles[2]) {}

  /// A vector in body axes written in inertial axes, (3.3).
  [[nodiscard]] Triple<T> ToInertial(const Triple<T>& body) const {
    const T x = cos_pitch * body[0] + sin_pitch * (sin_roll * body[1] + cos_roll * body[2]);
    const T y = cos_roll * body[1] - sin_roll * body[2];
    return {cos_yaw * x - sin_yaw * y,
            sin_yaw * x + cos_yaw * y,
            cos_pitch * (sin_roll * body[1] + cos_roll * body[2]) - sin_pitch * body[0]};
  }
  /// The other way: its transpose.
  [[nodiscard]] Triple<T> ToBody(const Triple<T>& inertial) const {
    const T x = cos_yaw * inertial[0] + sin_yaw * inertial[1];
    const T y = cos_yaw * inertial[1] - sin_yaw * inertial[0];
    const T down = sin_pitch * x + cos_pitch * inertial[2];
    return {cos_pitch * x - sin_pitch * inertial[2],
            cos_roll * y + sin_roll * down,
            cos_roll * down - sin_roll * y};
  }
  /// The body's z axis in inertial axes: the last column of (3.3).
  [[nodiscard]] Triple<T> Down() const {
    return {cos_yaw * sin_pitch * cos_roll + sin_yaw * sin_roll,
            sin_yaw * sin_pitch * cos_roll - cos_yaw * sin_roll,
            cos_pitch * cos_roll};
  }

  /// rho' = S(rho) Omega, (3.6) and (3.8).
  [[nodiscard]] Triple<T> AngleRates(const Triple<T>& body_rates) const {
    const T across = sin_roll * body_rates[1] + cos_roll * body_rates[2];
    const T yaw_rate = across / cos_pitch;
    return {body_rates[0] + sin_pitch * yaw_rate,
            cos_roll * body_rates[1] - sin_roll * body_rates[2],
            yaw_rate};
  }
  /// S^-1 applied to rates (or accelerations) of the angles.
  [[nodiscard]] Triple<T> BodyRates(const Triple<T>& angle_rates) const {
    const T across = cos_pitch * angle_rates[2];
    return {angle_rates[0] - sin_pitch * angle_rates[2],
            cos_roll * angle_rates[1] + sin_roll * across,
            cos_roll * across - sin_roll * angle_rates[1]};
  }
  /// S'(rho, rho') Omega: what the change of S adds to rho'', with rho' = S Omega.
  [[nodiscard]] Triple<T> AngleRateDrift(const Triple<T>& body_rates) const {
    const Triple<T> rate = AngleRates(body_rates);
    const T along = cos_roll * body_rates[1] - sin_roll * body_rates[2];  // d across/d roll
    const T sec = T(1.0) / cos_pitch;
    const T tan = sin_pitch * sec;
    const T across = sin_roll * body_rates[1] + cos_roll * body_rates[2];
    const T yaw_drift = sec * (rate[0] * along + rate[1] * tan * across);
    // The first row of S is tan = sin sec times `across`: its change in pitch is sec² across.
    return {rate[0] * tan * along + rate[1] * sec * sec * across, -(rate[0] * across), yaw_drift};
  }
};

template <class T>
Triple<T> Cross(const Triple<T>& a, const Triple<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Omega x J Omega for a diagonal J, the gyroscopic torque of (3.7).
template <class T>
Triple<T> GyroscopicTorque(const std::array<double, 3>& inertia, const Triple<T>& rates) {
  return {(inertia[2] - inertia[1]) * (rates[1] * rates[2]),
          (inertia[0] - inertia[2]) * (rates[2] * rates[0]),
          (inertia[1] - inertia[0]) * (rates[0] * rates[1])};
}

}  // namespace lipoid
