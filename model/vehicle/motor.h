#pragma once

/// @file
/// One coreless direct-current motor with its propeller, (3.9)-(3.10), (3.14)-(3.16).
/// Tests: tests/model/vehicle/motor_test.cc.

#include <cmath>

#include "model/vehicle/vehicle.h"

namespace lipoid {

/// Armature current without inductance, (3.9).
template <class T>
T ArmatureCurrent(const Vehicle& v, const T& motor_voltage_V, const T& speed_rad_per_s) {
  return (motor_voltage_V - v.motor_constant_N_m_per_A * speed_rad_per_s) *
         (1.0 / v.armature_resistance_Ohm);
}

/// Acceleration of the rotor, (3.10). Drag brakes whichever way it turns.
template <class T>
T RotorAcceleration(const Vehicle& v, const T& current_A, const T& speed_rad_per_s) {
  using std::abs;
  return (v.motor_constant_N_m_per_A * current_A -
          (v.friction_N_m_s + v.torque_coefficient_N_m_s2 * abs(speed_rad_per_s)) *
              speed_rad_per_s) *
         (1.0 / v.rotor_inertia_kg_m2);
}

/// The time in which a speed near `speed_rad_per_s` settles at a constant voltage, of (3.9) and (3.10).
inline double SpeedConstant_s(const Vehicle& v, double speed_rad_per_s) {
  return v.rotor_inertia_kg_m2 / (v.speed_slope() / v.armature_resistance_Ohm +
                                  2.0 * v.torque_coefficient_N_m_s2 * speed_rad_per_s);
}

/// The voltage that holds a speed, D v_b of (3.16).
template <class T>
T HoldingVoltage(const Vehicle& v, const T& speed_rad_per_s) {
  return (v.speed_slope() +
          (v.armature_resistance_Ohm * v.torque_coefficient_N_m_s2) * speed_rad_per_s) *
         speed_rad_per_s * (1.0 / v.motor_constant_N_m_per_A);  // (3.16)
}

/// The current that holds a speed, (3.14) and (5.59).
template <class T>
T HoldingCurrent(const Vehicle& v, const T& speed_rad_per_s) {
  return (v.friction_N_m_s + v.torque_coefficient_N_m_s2 * speed_rad_per_s) * speed_rad_per_s *
         (1.0 / v.motor_constant_N_m_per_A);
}

/// The speed that a voltage >= 0 holds: (5.10), with D v_b in the place of xi and omega_C. Written
/// without the difference of two near numbers.
template <class T>
T HeldSpeed(const Vehicle& v, const T& motor_voltage_V) {
  using std::sqrt;
  const double gamma = v.gamma_rad_per_s();
  const T drive = motor_voltage_V * (v.motor_constant_N_m_per_A /
                                     (v.armature_resistance_Ohm * v.torque_coefficient_N_m_s2));
  return (2.0 * drive) / (gamma + sqrt(gamma * gamma + 4.0 * drive));
}

}  // namespace lipoid
