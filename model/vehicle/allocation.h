#pragma once

/// @file
/// Control allocation of an "x" quadrotor: torques and thrust from the squares of the motor speeds
/// and back, (3.12)-(3.13). Motors 1 to 4 are front right, back right, back left, front left seen
/// from above, with x forward and y to the right. Tests: tests/model/vehicle/allocation_test.cc.

#include <array>

#include "model/vehicle/rigid_body.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

template <class T>
using PerMotor = std::array<T, 4>;

/// Signs of a motor's share in roll, pitch and yaw: the rows of B, with front right turning
/// clockwise.
inline constexpr PerMotor<double> kRollSign{-1.0, -1.0, 1.0, 1.0};
inline constexpr PerMotor<double> kPitchSign{1.0, -1.0, -1.0, 1.0};
inline constexpr PerMotor<double> kYawSign{-1.0, 1.0, -1.0, 1.0};

template <class T>
struct Wrench {
  Triple<T> torque_N_m;  ///< L, M, N about the body axes
  T thrust_N;            ///< T, against the body's z axis
};

/// (3.12)
template <class T>
Wrench<T> WrenchOf(const Vehicle& vehicle, const PerMotor<T>& squared_speeds) {
  const auto& s = squared_speeds;
  const double k = vehicle.thrust_coefficient_N_s2;
  const double lever = vehicle.lever_m() * k;
  return {{lever * ((s[2] + s[3]) - (s[0] + s[1])),
           lever * ((s[0] + s[3]) - (s[1] + s[2])),
           vehicle.yaw_coefficient_N_m_s2() * ((s[1] + s[3]) - (s[0] + s[2]))},
          k * ((s[0] + s[1]) + (s[2] + s[3]))};
}

/// (3.13); a square may come out negative: no motor can do that.
template <class T>
PerMotor<T> SquaredSpeedsOf(const Vehicle& vehicle, const Wrench<T>& wrench) {
  const double k = 0.25 / vehicle.thrust_coefficient_N_s2;
  const double lever = k / vehicle.lever_m();
  const double yaw = 0.25 / vehicle.yaw_coefficient_N_m_s2();
  PerMotor<T> squared;
  for (std::size_t i = 0; i < 4; ++i) {
    squared[i] = k * wrench.thrust_N + (lever * kRollSign[i]) * wrench.torque_N_m[0] +
                 (lever * kPitchSign[i]) * wrench.torque_N_m[1] +
                 (yaw * kYawSign[i]) * wrench.torque_N_m[2];
  }
  return squared;
}

}  // namespace lipoid
