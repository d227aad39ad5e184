#pragma once

/// @file
/// Motor, propeller and speed controller from a bench table, by least squares.
///
/// A row at rest is the model of the vehicle itself: the throttle is the duty cycle D, and
///
///   D v_b = k_e omega + r i,  k_e i = b omega + k_N omega²     the speed, (5.10)
///   i_b   = (D + t f) i                                         the battery's current
///   T     = k_T omega²                                          the thrust
///
/// r is what the throttle sees between battery and back electromotive force: winding, transistors
/// and commutation together. Unknown are k_T, k_N, b and r, and k_e where the table has speeds and
/// no constant of the motor is given. Each channel (speed, current, thrust) has relative errors of
/// its own size, found from its residuals. Tests: tests/identify/vehicle/bench_fit_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/vehicle/bench_table.h"

namespace lipoid {

/// What is known beforehand and not fitted.
struct BenchGiven {
  std::optional<double> motor_constant_N_m_per_A = {};  ///< needed where the table has no speeds
  std::optional<double> friction_N_m_s = {};
  /// Whether the losses by switching are fitted too; they show as battery current that does not
  /// reach the motor.
  bool switching = false;
};

struct BenchQuantity {
  std::string name;  ///< a key of the vehicle file
  double estimate = 0.0;
  double standard_error = 0.0;  ///< 0 where it was given; NaN, as its interval, at its bound
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
  /// Root mean square of the relative residuals, by channel; the speed's is 0 where there is none.
  double speed_rms = 0.0;
  double current_rms = 0.0;
  double thrust_rms = 0.0;
  double degrees_of_freedom = 0.0;

  [[nodiscard]] std::vector<BenchQuantity> Quantities() const;
};

/// OptionError where the table has no speeds and no motor constant is given, and where it has too few
/// operating points to tell the errors of what is fitted.
[[nodiscard]] BenchFit FitBenchTable(const BenchTable& table, const BenchGiven& given);

}  // namespace lipoid
