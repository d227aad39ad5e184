#pragma once

/// @file
/// The flight controller as it runs on board, every 5 ms: references, position controller, error
/// controllers with anti-windup, dynamic inversion, allocation, command generation and PWM.
/// Tests: tests/model/control/flight_controller_test.cc.

#include <limits>
#include <string>
#include <vector>

#include "model/control/laws/control_laws.h"
#include "model/control/reference_model.h"
#include "model/core/options.h"

namespace lipoid {

inline constexpr double kControlStep_s = 0.005;  // t_s of section 6.1

/// What a maneuver asks for.
struct FlightCommand {
  double altitude_m = 0.0;
  double yaw_rad = 0.0;
  bool hold_position = true;  ///< else roll and pitch are commanded
  double x_m = 0.0;
  double y_m = 0.0;
  double roll_rad = 0.0;
  double pitch_rad = 0.0;
};

struct ControllerOptions {
  std::string law = "inversion";  ///< a name of ControlLaws()
  double altitude_omega_rad_per_s = 5.0;
  double altitude_damping = 1.0;
  double attitude_omega_rad_per_s = 100.0;
  double attitude_damping = 1.0;
  double yaw_omega_rad_per_s = 4.0;
  double position_omega_rad_per_s = 1.2;
  double position_speed_m_per_s = 1.5;
  bool compensate = false;
  bool saturate = true;
  Pwm pwm = Pwm::kCarried;
  bool limit_reference = true;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    const Range omega{0.01, 1e4};
    const Range damping{0.01, 100.0};
    v("law",
      self.law,
      Names(),
      "control law of the inner loops, a name of `lipoid list controllers`");
    v("altitude_omega_rad_per_s",
      self.altitude_omega_rad_per_s,
      omega,
      "natural frequency of the altitude's reference model, rad/s");
    v("altitude_damping",
      self.altitude_damping,
      damping,
      "damping ratio of the altitude's reference model");
    v("attitude_omega_rad_per_s",
      self.attitude_omega_rad_per_s,
      omega,
      "natural frequency of the reference models of roll and pitch, rad/s");
    v("attitude_damping",
      self.attitude_damping,
      damping,
      "damping ratio of the reference models of roll and pitch");
    v("yaw_omega_rad_per_s",
      self.yaw_omega_rad_per_s,
      omega,
      "natural frequency of the heading's reference model, which is critically damped, rad/s");
    v("position_omega_rad_per_s",
      self.position_omega_rad_per_s,
      omega,
      "natural frequency of the reference models of x and y, which are critically damped, rad/s");
    v("position_speed_m_per_s",
      self.position_speed_m_per_s,
      omega,
      "largest speed of the reference models of x and y, m/s");
    v("saturate", self.saturate, Names(), "whether duty cycles are limited to [0, 1]");
    v("pwm",
      self.pwm,
      Names(),
      "how duty cycles become the integers of the hardware: rounded, rounded with the remainder "
      "carried to the next step, or not at all");
    v("limit_reference",
      self.limit_reference,
      Names(),
      "whether the references of the angles and the yaw torque are limited to what the motors can "
      "do");
  }
};

/// What the controller is told of the vehicle.
struct MeasuredState {
  Triple<double> position_m{};        ///< z down
  Triple<double> velocity_m_per_s{};  ///< inertial
  Triple<double> angles_rad{};
  Triple<double> body_rates_rad_per_s{};
  double battery_V = 0.0;
};

/// Accelerations of the angles' references in rad/s² that motors of this highest speed can follow:
/// what they can be moved from hover, up or down, before one saturates, shared out between roll,
/// pitch and yaw with a rest for the altitude and the feedback.
[[nodiscard]] Triple<double> AngleReferenceLimits(const Vehicle& vehicle, double highest_speed);

class FlightController {
 public:
  /// OptionError where there is no such control law.
  FlightController(Vehicle vehicle, Gains gains, const ControllerOptions& options);

  /// At rest at a state and a heading, hovering with duty cycles that commanded speeds of
  /// `commanded_speed` give: e_I starts where (5.21) has its equilibrium, not at zero, from where
  /// the vehicle would drop by metres. `highest_speed` is what the motors reach at D = 1.
  void Reset(const MeasuredState& state, double commanded_speed, double highest_speed);

  /// Duty cycles for the coming step. Does not allocate.
  MotorValues Step(const FlightCommand& command, const MeasuredState& state);

  /// Of the last step.
  [[nodiscard]] const InnerLoopReferences<double>& references() const { return references_; }
  [[nodiscard]] const InnerLoopOutput<double>& output() const { return output_; }
  /// Squares of the commanded speeds, saturated.
  [[nodiscard]] const MotorValues& speed_squared() const { return speed_squared_; }
  [[nodiscard]] bool saturated() const { return saturated_; }
  [[nodiscard]] const ErrorIntegrals<double>& integrals() const { return integrals_; }

  /// What was derived from vehicle, gains and options, after Reset() with the bounds that it set;
  /// for code that is exported.
  [[nodiscard]] const ReferenceModel& down_reference() const { return down_; }
  [[nodiscard]] const ReferenceModel& angle_reference(std::size_t axis) const {
    return angles_[axis];
  }
  [[nodiscard]] const ReferenceModel& position_reference() const { return position_[0]; }
  [[nodiscard]] double yaw_limit_N_m() const { return yaw_limit_N_m_; }

 private:
  [[nodiscard]] TiltCommand Tilt(const FlightCommand& command, const MeasuredState& state);
  MotorValues Duties(double battery_V);

  Vehicle vehicle_;
  Gains gains_;
  ControllerOptions options_;
  const ControlLaw* law_;
  ReferenceModel down_;
  std::array<ReferenceModel, 3> angles_;
  std::array<ReferenceModel, 2> position_;
  std::vector<PulseWidth> pulse_width_;
  InnerLoopReferences<double> references_{};
  ErrorIntegrals<double> integrals_{};
  InnerLoopOutput<double> output_{};
  MotorValues speed_squared_;
  double yaw_limit_N_m_ = std::numeric_limits<double>::infinity();
  bool saturated_ = false;
};

}  // namespace lipoid
