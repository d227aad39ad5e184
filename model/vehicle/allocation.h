#pragma once

/// @file
/// Control allocation: torques and thrust from the squares of the motor speeds and back.
///
///   L = l k_T sum -f_i sin(a_i) s_i     roll, with a_i the angle of rotor i from the nose,
///   M = l k_T sum  f_i cos(a_i) s_i     pitch       f_i its share of thrust: 1, less for a lower
///   N =   k_N sum -t_i s_i              yaw         rotor of a coaxial pair, t_i = 1 or -1 its
///   T =   k_T sum  f_i s_i              thrust      turning, s_i the square of its speed
///
/// Of a quad-x these are (3.12) and (3.13). Where there are more rotors than wrenches the squares
/// are those with the least sum of f_i s_i²: without coaxial pairs the pseudo-inverse, with them
/// the one that hovers with all rotors at one speed. In every layout the rows above are orthogonal
/// under these weights, so that the inverse is a sum of four terms. Tests:
/// tests/model/vehicle/allocation_test.cc.

#include <array>
#include <boost/container/static_vector.hpp>
#include <span>

#include "model/vehicle/rigid_body.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

/// One number for each motor, in the order of the layout.
template <class T, std::size_t R = 4>
using PerMotor = std::array<T, R>;

/// The same where the number of motors is known when it flies. Does not allocate.
using MotorValues = boost::container::static_vector<double, kMostRotors>;

/// Signs of a motor's share in roll, pitch and yaw: the rows of B of a quad-x, (3.12), with front
/// right turning clockwise.
inline constexpr PerMotor<double> kRollSign{-1.0, -1.0, 1.0, 1.0};
inline constexpr PerMotor<double> kPitchSign{1.0, -1.0, -1.0, 1.0};
inline constexpr PerMotor<double> kYawSign{-1.0, 1.0, -1.0, 1.0};

template <class T>
struct Wrench {
  Triple<T> torque_N_m;  ///< L, M, N about the body axes
  T thrust_N;            ///< T, against the body's z axis
};

/// Of R motors, as many as the vehicle has.
template <class T, std::size_t R = 4>
Wrench<T> WrenchOf(const Vehicle& vehicle, const PerMotor<T, R>& squared_speeds) {
  const auto& s = squared_speeds;
  const double k = vehicle.thrust_coefficient_N_s2;
  if constexpr (R == 4) {
    if (vehicle.layout == RotorLayout::kQuadX) {
      const double lever = vehicle.lever_m() * k;
      return {{lever * ((s[2] + s[3]) - (s[0] + s[1])),
               lever * ((s[0] + s[3]) - (s[1] + s[2])),
               vehicle.yaw_coefficient_N_m_s2() * ((s[1] + s[3]) - (s[0] + s[2]))},
              k * ((s[0] + s[1]) + (s[2] + s[3]))};  // (3.12)
    }
  }
  const auto rotors = RotorsOf(vehicle.layout);
  T roll(0.0);
  T pitch(0.0);
  T yaw(0.0);
  T thrust(0.0);
  for (std::size_t i = 0; i < R; ++i) {
    const T share = vehicle.ThrustShare(rotors[i]) * s[i];
    roll = roll - rotors[i].right * share;
    pitch = pitch + rotors[i].ahead * share;
    yaw = yaw - rotors[i].turning * s[i];
    thrust = thrust + share;
  }
  return {
      {vehicle.arm_m * k * roll, vehicle.arm_m * k * pitch, vehicle.yaw_coefficient_N_m_s2() * yaw},
      k * thrust};
}

/// The squares for a wrench, one for each motor of the vehicle; a square may come out negative: no
/// motor can do that.
template <class T>
void Allocate(const Vehicle& vehicle, const Wrench<T>& wrench, std::span<T> squares) {
  if (vehicle.layout == RotorLayout::kQuadX) {
    const double k = 0.25 / vehicle.thrust_coefficient_N_s2;
    const double lever = k / vehicle.lever_m();
    const double yaw = 0.25 / vehicle.yaw_coefficient_N_m_s2();
    for (std::size_t i = 0; i < 4; ++i) {
      squares[i] = k * wrench.thrust_N + (lever * kRollSign[i]) * wrench.torque_N_m[0] +
                   (lever * kPitchSign[i]) * wrench.torque_N_m[1] +
                   (yaw * kYawSign[i]) * wrench.torque_N_m[2];  // (3.13)
    }
    return;
  }
  const auto rotors = RotorsOf(vehicle.layout);
  const RotorSums sums = vehicle.SumsOverRotors();
  const double k = vehicle.thrust_coefficient_N_s2;
  const double roll = 1.0 / (vehicle.arm_m * k * sums.right_squared);
  const double pitch = 1.0 / (vehicle.arm_m * k * sums.ahead_squared);
  const double yaw = 1.0 / (vehicle.yaw_coefficient_N_m_s2() * sums.per_thrust);
  const double thrust = 1.0 / (k * sums.thrust);
  for (std::size_t i = 0; i < rotors.size(); ++i) {
    squares[i] = thrust * wrench.thrust_N - (roll * rotors[i].right) * wrench.torque_N_m[0] +
                 (pitch * rotors[i].ahead) * wrench.torque_N_m[1] -
                 (yaw * rotors[i].turning / vehicle.ThrustShare(rotors[i])) * wrench.torque_N_m[2];
  }
}

/// Of R motors, as many as the vehicle has.
template <std::size_t R = 4, class T>
PerMotor<T, R> SquaredSpeedsOf(const Vehicle& vehicle, const Wrench<T>& wrench) {
  PerMotor<T, R> squared;
  Allocate<T>(vehicle, wrench, squared);
  return squared;
}

/// Torques about the three axes per square of speed, where every rotor's square changes by as much
/// as any other's, up on one side and down on the other.
[[nodiscard]] Triple<double> TorqueReach(const Vehicle& vehicle);

/// The quadrotor on an X whose motors do what the vehicle's do: for the same accelerations of the
/// body the squares of their speeds change as much as those of the vehicle's hardest worked rotor.
/// Loops around it have the vehicle's poles. A quad-x is its own.
[[nodiscard]] Vehicle EquivalentQuadrotor(const Vehicle& vehicle);

}  // namespace lipoid
