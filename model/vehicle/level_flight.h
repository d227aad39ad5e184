#pragma once

/// @file
/// What steady level flight asks of the propulsion: rotor speed, motor voltage and current, and the
/// electrical power that the battery has to give. Tests: tests/model/vehicle/level_flight_test.cc.
///
///   T = m g/n,  omega = sqrt(T/k_T)                        (3.12) in hover
///   D v_b = ((k_e² + r_a b) omega + r_a k_N omega²)/k_e    (3.16)
///   i = (b omega + k_N omega²)/k_e                         (3.14)
///   P = n D v_b i                                          (3.11), whatever v_b is

#include "model/vehicle/vehicle.h"

namespace lipoid {

/// The working point of the motors, all alike.
struct LevelFlight {
  double thrust_N = 0.0;  ///< of all rotors together
  double speed_rad_per_s = 0.0;
  double motor_V = 0.0;  ///< D v_b of each motor: a battery below it cannot keep the vehicle up
  double motor_A = 0.0;
  double shaft_W = 0.0;    ///< that all propellers take
  double battery_W = 0.0;  ///< that the battery gives
};

/// Hover in still air. PreconditionError unless the vehicle has mass, thrust and motors.
[[nodiscard]] LevelFlight Hover(const Vehicle& vehicle);

}  // namespace lipoid
