#pragma once

/// @file
/// Motor, propeller and speed controller from a bench table, by least squares.
///
/// A row at rest is the model of the vehicle itself, at the duty cycle D that the throttle u makes:
///
///   D v_b = k_e omega + r i,  k_e i = b omega + k_N omega²     the speed, (5.10)
///   i_b   = (D + t f) i                                         the battery's current
///   T     = k_T omega²                                          the thrust
///   D     = u^n                                                 the speed controller
///
/// r is what lies between battery and back electromotive force: winding, transistors and commutation
/// together. Unknown are k_T, k_N, b, r and n, and k_e where the table has speeds and no constant of
/// the motor is given. A speed is measured far better than the throttle is known to be a duty cycle:
/// where the table has speeds, the duty cycle, the current and the thrust of a row are those of its
/// speed, and the throttle says nothing of k_T. Without speeds n is one within what is usual.
/// Friction is at most kMostFriction of the torque of the fastest row. Each channel (speed, current,
/// thrust) has relative errors of its own size, found from its residuals.
/// Tests: tests/identify/vehicle/bench_fit_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/vehicle/bench_table.h"

namespace lipoid {

/// Motors without propeller draw 2 to 10 % of the current that they draw with it at full throttle.
inline constexpr double kMostFriction = 0.15;

/// What is known beforehand and not fitted.
struct BenchGiven {
  std::optional<double> motor_constant_N_m_per_A = {};  ///< needed where the table has no speeds
  /// Current without load over the voltage that then turns the motor, G: b = k_e² G.
  std::optional<double> no_load_A_per_V = {};
  /// Whether the losses by switching are fitted too; they show as battery current that does not
  /// reach the motor.
  bool switching = false;
};

struct BenchQuantity {
  std::string name;  ///< a key of the vehicle file, or that of a share or exponent
  double estimate = 0.0;
  /// 0 where it was not fitted; NaN, as its interval, at its bound and where the table does not show it.
  double standard_error = 0.0;
  double low_95 = 0.0;
  double high_95 = 0.0;
  bool fitted = true;
};

struct BenchFit {
  bool converged = false;
  std::string message;
  BenchQuantity thrust_coefficient_N_s2;
  BenchQuantity torque_coefficient_N_m_s2;
  BenchQuantity motor_constant_N_m_per_A;
  BenchQuantity resistance_Ohm;
  BenchQuantity friction_N_m_s;
  BenchQuantity switching_share;
  BenchQuantity
      throttle_exponent;  ///< n; no key of the vehicle file, and 1 where D is the throttle
  /// Root mean square of the relative residuals, by channel; the speed's is 0 where there is none.
  double speed_rms = 0.0;
  double current_rms = 0.0;
  double thrust_rms = 0.0;
  double degrees_of_freedom = 0.0;
  bool has_speed = false;         ///< of the table
  bool friction_at_most = false;  ///< friction is at kMostFriction
  /// Every row is at full throttle: they show neither switching nor the exponent, which are not fitted.
  bool full_throttle = false;

  [[nodiscard]] std::vector<BenchQuantity> Quantities() const;
};

/// OptionError where the table has no speeds and no motor constant is given, where it has too few
/// operating points to tell the errors of what is fitted, where it leaves nothing for the resistance or, without
/// a motor constant, half of the voltage, and where its throttle is far from a duty cycle. What goes with a
/// quantity at its bound is as uncertain as if that were free.
[[nodiscard]] BenchFit FitBenchTable(const BenchTable& table, const BenchGiven& given);

}  // namespace lipoid
