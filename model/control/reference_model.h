#pragma once

/// @file
/// Reference model of second order, (3.59) with its sign corrected (docs/corrections.md):
///
///   y_ref'' + 2 zeta_0 omega_0 y_ref' = omega_0² (y_C - y_ref)
///
/// stepped exactly for a command held over a step. The acceleration that is handed out is the mean
/// over the coming step: a controller that holds its output over the step then gives the vehicle
/// exactly the reference's change of rate. (Its value at the sample does not: at omega_0 = 100
/// rad/s and 5 ms a step of 4 degrees would leave a rate of 2 rad/s behind.) A limit on the
/// acceleration keeps the reference within what the motors can do; it then also brakes in time, so
/// that with zeta_0 >= 1 no command however far is overshot. Tests:
/// tests/model/control/reference_model_test.cc.

#include <array>
#include <limits>

namespace lipoid {

class ReferenceModel {
 public:
  struct Output {
    double value;
    double rate;
    double acceleration;  ///< mean over the coming step
  };

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
  Output Step(double command);

  [[nodiscard]] double value() const { return value_; }

 private:
  double step_s_;
  double limit_;
  double far_;                  // the gap beyond which the limit could no longer brake
  std::array<double, 4> flow_;  // transition of (value - command, rate) over a step
  double value_ = 0.0;
  double rate_ = 0.0;
};

}  // namespace lipoid
