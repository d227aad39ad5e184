#pragma once

/// @file
/// Where battery and motors meet: the one place.
///
/// Whatever supplies the motors is, for one short step, a voltage behind a resistance: an ideal
/// source is xi v_b0 behind none, a cell is v_oc - sum v_cj behind r_s and the tail's share
/// (battery_supply.h). Between it and each motor is a speed controller:
///
///   D v_b - (1 - D) V_d - k_e omega = (r_a + R) i        the motor's loop, (3.9) without losses
///   i_b = sum (D i + t f |i|) + P/v_b                    the battery's current, (3.11) without
///
/// R is the resistance of the transistors that the current flows through, V_d the drop of diodes
/// that it flows through between pulses where transistors do not (i is then never below 0), t f the
/// share of a period in which a transistor that switches has both voltage and current: none at D =
/// 0 and D = 1, where it does not switch. P is the power of the avionics. With transistors throughout,
/// a motor that slows down has i < 0 and charges the battery.
///
/// The battery current depends on v_b and v_b on it. Without losses the loop has a closed form. With
/// them it is one for each set of signs of the currents, a quadratic because of P; from the set in
/// which all are positive, signs are corrected until they hold, which is Newton's iteration on a
/// line with corners. Where no voltage gives the power, v_b is that of the largest power. Tests:
/// tests/model/vehicle/powertrain_test.cc.

#include <cmath>

#include "model/battery/exact_hold.h"
#include "model/vehicle/allocation.h"
#include "model/vehicle/motor.h"

namespace lipoid {

/// v_b = voltage - resistance i_b.
template <class T>
struct Supply {
  T voltage_V;
  T resistance_Ohm;  ///< >= 0
};

/// Sum of a_i b_i, by pairs.
template <class T, std::size_t R = 4>
T SumOfProducts(const PerMotor<T, R>& a, const PerMotor<T, R>& b) {
  T sum = a[0] * b[0] + a[1] * b[1];
  for (std::size_t i = 2; i + 1 < R; i += 2) sum = sum + (a[i] * b[i] + a[i + 1] * b[i + 1]);
  return sum;
}

/// i_b = sum D_i i_i, (3.11): the battery's current without losses and avionics.
template <class T, std::size_t R = 4>
T BatteryCurrent(const PerMotor<T, R>& duty, const PerMotor<T, R>& current_A) {
  return SumOfProducts(duty, current_A);  // (3.11)
}

/// Motors in series with the transistors of their controllers: what voltages across both drive.
inline Vehicle WithControllers(Vehicle vehicle) {
  vehicle.armature_resistance_Ohm += vehicle.esc.resistance_Ohm;
  return vehicle;
}

/// What a speed controller puts across winding and transistors, without the motor's own voltage.
template <class T>
T DriveVoltage(const SpeedController& esc, const T& duty, const T& battery_V) {
  if (esc.synchronous) return duty * battery_V;
  return duty * battery_V - (T(1.0) - duty) * esc.diode_V;
}

/// The motor's current with l_a = 0.
template <class T>
T MotorCurrent(const Vehicle& v, const T& duty, const T& battery_V, const T& speed_rad_per_s) {
  if (v.esc.lossless()) return ArmatureCurrent(v, T(duty * battery_V), speed_rad_per_s);  // (3.9)
  const T current_A =
      (DriveVoltage(v.esc, duty, battery_V) - v.motor_constant_N_m_per_A * speed_rad_per_s) *
      (1.0 / (v.armature_resistance_Ohm + v.esc.resistance_Ohm));
  return !v.esc.synchronous && ScalarPart(current_A) < 0.0 ? T(0.0) : current_A;
}

/// What a motor's current of this sign is multiplied with to give the battery's share of it.
template <class T>
T CurrentShare(const SpeedController& esc, const T& duty, bool positive) {
  const double at = ScalarPart(duty);
  if (!(at > 0.0 && at < 1.0)) return duty;
  return positive ? duty + esc.SwitchingShare() : duty - esc.SwitchingShare();
}

/// The current of all motors' controllers, from the motors' currents.
template <class T, std::size_t R = 4>
T ControllersCurrent(const Vehicle& v,
                     const PerMotor<T, R>& duty,
                     const PerMotor<T, R>& current_A) {
  if (v.esc.lossless()) return BatteryCurrent(duty, current_A);
  PerMotor<T, R> share;
  for (std::size_t i = 0; i < R; ++i) {
    share[i] = CurrentShare(v.esc, duty[i], ScalarPart(current_A[i]) > 0.0);
  }
  return SumOfProducts(share, current_A);
}

/// The upper root of a v² - b v + c = 0 with a > 0, b > 0, c >= 0; where there is none, the vertex.
template <class T>
T UpperRoot(const T& a, const T& b, const T& c) {
  using std::sqrt;
  if (ScalarPart(c) == 0.0) return b / a;
  const T discriminant = b * b - 4.0 * a * c;
  if (!(ScalarPart(discriminant) > 0.0)) return b / (2.0 * a);
  return (b + sqrt(discriminant)) / (2.0 * a);
}

/// v_b while the motors' currents are given, as with l_a > 0.
template <class T>
T VoltageUnderCurrent(const Vehicle& v, const Supply<T>& supply, const T& motors_A) {
  const T open_V = supply.voltage_V - supply.resistance_Ohm * motors_A;
  if (v.avionics_power_W == 0.0) return open_V;
  return UpperRoot(T(1.0), open_V, T(supply.resistance_Ohm * v.avionics_power_W));
}

/// v_b with l_a = 0: motors' loops and battery solved together.
template <class T, std::size_t R = 4>
T LoopVoltage(const Vehicle& v,
              const Supply<T>& supply,
              const PerMotor<T, R>& duty,
              const PerMotor<T, R>& speed) {
  if (v.lossless_supply()) {
    const T share = supply.resistance_Ohm * (1.0 / v.armature_resistance_Ohm);  // R/r_a
    const T generated = SumOfProducts(duty, speed);
    const T squares = SumOfProducts(duty, duty);
    return (supply.voltage_V + share * v.motor_constant_N_m_per_A * generated) /
           (T(1.0) + share * squares);  // (3.9) and (3.11)
  }
  const double conductance_S = 1.0 / (v.armature_resistance_Ohm + v.esc.resistance_Ohm);
  const T& resistance = supply.resistance_Ohm;
  std::array<int, R> sign;
  sign.fill(1);
  T battery_V = supply.voltage_V;
  for (std::size_t round = 0; round < R + 2; ++round) {
    // i_b = slope v_b - held + P/v_b
    T slope(0.0);
    T held(0.0);
    for (std::size_t i = 0; i < R; ++i) {
      if (sign[i] == 0) continue;
      const T share = CurrentShare(v.esc, duty[i], sign[i] > 0) * conductance_S;
      const T against_V =
          v.motor_constant_N_m_per_A * speed[i] - DriveVoltage(v.esc, duty[i], T(0.0));
      slope = slope + share * duty[i];
      held = held + share * against_V;
    }
    battery_V = UpperRoot(T(T(1.0) + resistance * slope),
                          T(supply.voltage_V + resistance * held),
                          T(resistance * v.avionics_power_W));
    bool holds = true;
    for (std::size_t i = 0; i < R; ++i) {
      const T drive_V = DriveVoltage(v.esc, duty[i], battery_V);
      const bool positive = ScalarPart(drive_V) > v.motor_constant_N_m_per_A * ScalarPart(speed[i]);
      const int now = positive ? 1 : v.esc.synchronous ? -1 : 0;
      holds = holds && now == sign[i];
      sign[i] = now;
    }
    if (holds) break;
  }
  return battery_V;
}

}  // namespace lipoid
