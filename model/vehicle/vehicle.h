#pragma once

/// @file
/// A quadrotor as data: what a vehicle file holds. SI units; the numbers are those of the thesis'
/// Table 6.1 with its misprints corrected (docs/corrections.md). Tests:
/// tests/model/vehicle/vehicle_file_test.cc.

#include <array>
#include <string>
#include <string_view>
#include <utility>

namespace lipoid {

inline constexpr double kGravity_m_per_s2 = 9.81;  // the thesis' g

enum class Turning { kClockwise, kCounterClockwise };

constexpr std::array<std::pair<Turning, std::string_view>, 2> OptionNames(Turning) {
  return {{{Turning::kClockwise, "clockwise"}, {Turning::kCounterClockwise, "counter-clockwise"}}};
}

struct Vehicle {
  std::string name;
  std::string summary;

  double mass_kg = 0.0;                          ///< m > 0
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
  /// Seen from above; back left turns alike, the other two the other way. The thesis' B has it
  /// clockwise, ArduCopter's quad X counter-clockwise.
  Turning front_right_turns = Turning::kClockwise;

  /// l_x = l sin 45 degrees, the lever of a motor about either horizontal axis, (3.12).
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
