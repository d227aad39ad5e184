#pragma once

/// @file
/// Where battery and motors meet, (3.11): the one place.
///
/// Whatever supplies the motors is, for one short step, a voltage behind a resistance: an ideal
/// source is xi v_b0 behind none, a cell is v_oc - sum v_cj behind r_s and the tail's share
/// (battery_supply.h). The battery current is i_b = sum D_i i_i and each i_i depends on v_b, so v_b
/// is the solution of a loop, which has a closed form. Tests:
/// tests/model/vehicle/powertrain_test.cc.

#include "model/vehicle/allocation.h"
#include "model/vehicle/motor.h"

namespace lipoid {

/// v_b = voltage - resistance i_b.
template <class T>
struct Supply {
  T voltage_V;
  T resistance_Ohm;  ///< >= 0
};

/// v_b with l_a = 0: (3.9) and (3.11) solved together.
template <class T>
T LoopVoltage(const Vehicle& v,
              const Supply<T>& supply,
              const PerMotor<T>& duty,
              const PerMotor<T>& speed) {
  const T share = supply.resistance_Ohm * (1.0 / v.armature_resistance_Ohm);  // R/r_a
  const T generated =
      (duty[0] * speed[0] + duty[1] * speed[1]) + (duty[2] * speed[2] + duty[3] * speed[3]);
  const T squares =
      (duty[0] * duty[0] + duty[1] * duty[1]) + (duty[2] * duty[2] + duty[3] * duty[3]);
  return (supply.voltage_V + share * v.motor_constant_N_m_per_A * generated) /
         (T(1.0) + share * squares);
}

/// i_b = sum D_i i_i, (3.11).
template <class T>
T BatteryCurrent(const PerMotor<T>& duty, const PerMotor<T>& current_A) {
  return (duty[0] * current_A[0] + duty[1] * current_A[1]) +
         (duty[2] * current_A[2] + duty[3] * current_A[3]);
}

}  // namespace lipoid
