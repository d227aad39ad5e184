#pragma once

/// @file
/// Reference model of second order, (3.59) with its sign corrected (docs/corrections.md):
///
///   y_ref'' + 2 zeta_0 omega_0 y_ref' = omega_0² (y_C - y_ref)
///
/// in steps over which the acceleration is held, as a controller holds its output: a vehicle that
/// does what it is told follows value and rate exactly, and nothing is left for the feedback. The
/// poles are those of (3.59), e^{p step}; a step answer differs from the continuous one by
/// (omega_0 step)²/12 of the acceleration. (The acceleration of (3.59) at the sample, or its mean
/// over the step, leaves what feedback must mend: at omega_0 = 100 rad/s and 5 ms a step of 4
/// degrees a rate of 2 rad/s, or 2 % of the step.) A limit on the acceleration keeps the reference
/// within what the motors can do; it then also brakes in time, so that with zeta_0 >= 1 no command
/// however far is overshot. Tests: tests/model/control/reference_model_test.cc.

#include <limits>

namespace lipoid {

template <class T>
struct LoopReference {
  T value{};
  T rate{};
  T acceleration{};  ///< held over the coming step
};

class ReferenceModel {
 public:
  /// omega_0 > 0, zeta_0 > 0, step > 0; limit > 0 of |y_ref''|.
  ReferenceModel(double omega_rad_per_s,
                 double damping,
                 double step_s,
                 double limit = std::numeric_limits<double>::infinity());

  /// At rest at a value.
  void Reset(double value) {
    value_ = value;
    rate_ = 0.0;
  }
  /// The reference now; moves on by one step under the command.
  LoopReference<double> Step(double command);

  [[nodiscard]] double value() const { return value_; }
  [[nodiscard]] double rate() const { return rate_; }

  /// The numbers of which a step is made, for code that is exported: the acceleration against a gap
  /// in 1/s² and against the rate in 1/s, the bound of the acceleration, and the gap beyond which
  /// that could no longer brake.
  [[nodiscard]] double per_gap() const { return per_gap_; }
  [[nodiscard]] double per_rate() const { return per_rate_; }
  [[nodiscard]] double limit() const { return limit_; }
  [[nodiscard]] double far() const { return far_; }

 private:
  double step_s_;
  double limit_;
  double far_;             // the gap beyond which the limit could no longer brake
  double per_gap_ = 0.0;   // acceleration against a gap, in 1/s²
  double per_rate_ = 0.0;  // and against the rate, in 1/s
  double value_ = 0.0;
  double rate_ = 0.0;
};

}  // namespace lipoid
