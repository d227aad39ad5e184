#pragma once

/// @file
/// A multirotor as data: what a vehicle file holds. SI units; symbols are those of the thesis' Table
/// 6.1. What a file may leave out has the value that makes the thesis' quadrotor: four rotors on an
/// X, speed controllers without losses, nothing else on the battery. Tests:
/// tests/model/vehicle/vehicle_file_test.cc.

#include <array>
#include <string>
#include <string_view>
#include <utility>

#include "model/core/options.h"
#include "model/vehicle/rotor_layout.h"

namespace lipoid {

inline constexpr double kGravity_m_per_s2 = 9.81;  // the thesis' g

enum class Turning { kClockwise, kCounterClockwise };

constexpr std::array<std::pair<Turning, std::string_view>, 2> OptionNames(Turning) {
  return {{{Turning::kClockwise, "clockwise"}, {Turning::kCounterClockwise, "counter-clockwise"}}};
}

/// An electronic speed controller and what it loses, model/vehicle/powertrain.h. Without losses it
/// is (3.11).
struct SpeedController {
  double resistance_Ohm = 0.0;    ///< >= 0; of the transistors that a motor's current flows through
  double switching_time_s = 0.0;  ///< >= 0; mean of the rise and the fall of a transistor
  double switching_frequency_Hz = 0.0;  ///< >= 0; of the pulse width modulation
  double diode_V = 0.0;  ///< >= 0; drop of the diodes, where it does not rectify synchronously
  /// True: while the pulse is off the motor's current flows through transistors and may reverse, so
  /// that a motor which slows down charges the battery. False: it flows through diodes and stops.
  bool synchronous = true;

  [[nodiscard]] bool lossless() const {
    return resistance_Ohm == 0.0 && SwitchingShare() == 0.0 && synchronous;
  }
  /// Share of a period in which a transistor has both voltage and current, t f.
  [[nodiscard]] double SwitchingShare() const { return switching_time_s * switching_frequency_Hz; }
};

/// Sums over the rotors of a layout, each weighted with its share of thrust f.
struct RotorSums {
  double thrust = 0.0;         ///< of f
  double ahead_squared = 0.0;  ///< of f cos² of the angle from the nose
  double right_squared = 0.0;  ///< of f sin²
  double per_thrust = 0.0;     ///< of 1/f
};

inline constexpr Range kPayloads_kg{0.0, 1e3};  ///< what a vehicle may be asked to carry
inline constexpr double kGram_kg = 1e-3;

struct Vehicle {
  std::string name;
  std::string summary;

  double mass_kg = 0.0;                          ///< m > 0, taking off: with battery and payload
  std::array<double, 3> inertia_kg_m2{};         ///< J_x, J_y, J_z > 0; none above the others' sum
  double arm_m = 0.0;                            ///< l > 0, from the centre of mass to a propeller
  double thrust_coefficient_N_s2 = 0.0;          ///< k_T > 0, thrust per square of rad/s
  double torque_coefficient_N_m_s2 = 0.0;        ///< k_N > 0, torque per square of rad/s
  double motor_constant_N_m_per_A = 0.0;         ///< k_e > 0
  double armature_resistance_Ohm = 0.0;          ///< r_a > 0
  double armature_inductance_H = 0.0;            ///< l_a >= 0
  double friction_N_m_s = 0.0;                   ///< b >= 0
  double rotor_inertia_kg_m2 = 0.0;              ///< J^P > 0, rotor and propeller
  double nominal_voltage_V = 0.0;                ///< v_b0 > 0
  std::array<double, 2> pwm_range{10.0, 500.0};  ///< omega_PWM at D = 0 and D = 1, (6.1)
  double linear_drag_N_s_per_m = 0.0;            ///< >= 0; acts only where drag is on
  RotorLayout layout = RotorLayout::kQuadX;
  /// Of the first rotor of the layout, seen from above; it is front right in a quad-x, where back
  /// left turns alike and the other two the other way. The thesis' B has it clockwise, ArduCopter's
  /// quad X counter-clockwise.
  Turning front_right_turns = Turning::kClockwise;
  /// Thrust of the lower rotor of a coaxial pair over that of the upper one at the same speed, in
  /// (0, 1]: it works in the upper one's stream.
  double lower_rotor_thrust_ratio = 1.0;
  double propeller_diameter_m = 0.0;  ///< >= 0; 0: not known
  double avionics_power_W = 0.0;      ///< >= 0; what the battery gives to all but the motors
  int series_cells = 0;               ///< of the pack that it is made for; 0: not known
  SpeedController esc;                ///< one for each motor, all alike

  [[nodiscard]] std::size_t rotor_count() const { return RotorsOf(layout).size(); }
  /// f_i of model/vehicle/allocation.h.
  [[nodiscard]] double ThrustShare(const Rotor& rotor) const {
    return rotor.lower ? lower_rotor_thrust_ratio : 1.0;
  }
  [[nodiscard]] RotorSums SumsOverRotors() const {
    RotorSums sums;
    for (const Rotor& rotor : RotorsOf(layout)) {
      const double share = ThrustShare(rotor);
      sums.thrust += share;
      sums.ahead_squared += share * rotor.ahead * rotor.ahead;
      sums.right_squared += share * rotor.right * rotor.right;
      sums.per_thrust += 1.0 / share;
    }
    return sums;
  }
  /// Thrust of all rotors at one speed over the square of it, 4 k_T of a quadrotor.
  [[nodiscard]] double total_thrust_coefficient_N_s2() const {
    return SumsOverRotors().thrust * thrust_coefficient_N_s2;
  }
  /// Whether the battery's current is (3.11) and no more.
  [[nodiscard]] bool lossless_supply() const { return esc.lossless() && avionics_power_W == 0.0; }

  /// l_x = l sin 45 degrees, the lever of a quad-x's motor about either horizontal axis, (3.12).
  [[nodiscard]] double lever_m() const { return 0.70710678118654752440 * arm_m; }
  /// k_N with the sign of (3.12): what the motors that turn against front right add to the yaw.
  [[nodiscard]] double yaw_coefficient_N_m_s2() const {
    return front_right_turns == Turning::kClockwise ? torque_coefficient_N_m_s2
                                                    : -torque_coefficient_N_m_s2;
  }
  /// k_e² + r_a b, the slope of D v_b k_e in the speed, (3.16).
  [[nodiscard]] double speed_slope() const {
    return motor_constant_N_m_per_A * motor_constant_N_m_per_A +
           armature_resistance_Ohm * friction_N_m_s;
  }
  /// gamma = (k_e² + r_a b)/(r_a k_N) in rad/s, (5.4).
  [[nodiscard]] double gamma_rad_per_s() const {
    return speed_slope() / (armature_resistance_Ohm * torque_coefficient_N_m_s2);
  }
};

}  // namespace lipoid
