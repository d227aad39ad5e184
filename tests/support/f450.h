#pragma once

/// @file
/// A quadrotor of the F450 class for tests: 1.2 kg, three cells, 920 KV, propellers of 9.4 by 5
/// inches. Its motors take longer than the Mambo's, by which the thesis' gains were chosen.

#include "model/vehicle/vehicle.h"

namespace lipoid::test {

inline Vehicle F450() {
  Vehicle v;
  v.name = "f450-like";
  v.mass_kg = 1.2;
  v.inertia_kg_m2 = {0.0121, 0.0121, 0.0215};
  v.arm_m = 0.225;
  v.thrust_coefficient_N_s2 = 1.07e-5;    // C_T = 0.11, diameter 0.239 m
  v.torque_coefficient_N_m_s2 = 1.67e-7;  // C_P = 0.045
  v.motor_constant_N_m_per_A = 0.01038;   // 920 rpm/V
  v.armature_resistance_Ohm = 0.13;
  v.friction_N_m_s = 5e-6;
  v.rotor_inertia_kg_m2 = 4e-5;
  v.nominal_voltage_V = 12.6;
  v.pwm_range = {0.0, 1000.0};
  v.linear_drag_N_s_per_m = 0.3;
  return v;
}

}  // namespace lipoid::test
