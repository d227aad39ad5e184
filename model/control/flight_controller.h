#pragma once

/// @file
/// The flight controller as it runs on board, every 5 ms: references, position controller, error
/// controllers with anti-windup, dynamic inversion, allocation, command generation and PWM.
/// Tests: tests/model/control/flight_controller_test.cc.

#include <algorithm>
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
  double altitude_omega_rad_per_s = 0.0;
  double altitude_damping = 1.0;
  double attitude_omega_rad_per_s = 0.0;
  double attitude_damping = 1.0;
  double yaw_omega_rad_per_s = 0.0;
  double position_omega_rad_per_s = 0.0;
  double position_speed_m_per_s = 0.0;
  double climb_m_per_s = 0.0;
  double descent_m_per_s = 0.0;
  bool compensate = false;
  bool saturate = true;
  Pwm pwm = Pwm::kCarried;
  bool limit_reference = true;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    const Range omega{0.0, 1e4};
    const Range damping{0.01, 100.0};
    v("law",
      self.law,
      Names(),
      "control law of the inner loops, a name of `lipoid list controllers`");
    v("altitude_omega_rad_per_s",
      self.altitude_omega_rad_per_s,
      omega,
      "natural frequency of the altitude's reference model, rad/s; 0: that of the gains");
    v("altitude_damping",
      self.altitude_damping,
      damping,
      "damping ratio of the altitude's reference model");
    v("attitude_omega_rad_per_s",
      self.attitude_omega_rad_per_s,
      omega,
      "natural frequency of the reference models of roll and pitch, rad/s; 0: that of the gains");
    v("attitude_damping",
      self.attitude_damping,
      damping,
      "damping ratio of the reference models of roll and pitch");
    v("yaw_omega_rad_per_s",
      self.yaw_omega_rad_per_s,
      omega,
      "natural frequency of the heading's reference model, which is critically damped, rad/s; 0: "
      "that of the gains");
    v("position_omega_rad_per_s",
      self.position_omega_rad_per_s,
      omega,
      "natural frequency of the reference models of x and y, which are critically damped, rad/s; "
      "0: that of the gains");
    v("position_speed_m_per_s",
      self.position_speed_m_per_s,
      omega,
      "largest speed of the reference models of x and y, m/s; 0: that of the gains");
    v("climb_m_per_s",
      self.climb_m_per_s,
      omega,
      "largest speed upwards of the altitude's reference model, m/s; 0: that of the gains");
    v("descent_m_per_s",
      self.descent_m_per_s,
      omega,
      "largest speed downwards of the altitude's reference model, m/s; 0: that of the gains");
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

/// Frequencies and speeds that are flown: those of the options where they are given, else of the gains.
[[nodiscard]] References ReferencesOf(const References& of_gains, const ControllerOptions& options);

/// How far below and above its reference a commanded altitude counts. A reference model settles at
/// omega_0/(2 zeta_0) times the gap: a gap that is cut keeps the speed.
struct AltitudeReach {
  double climb_m;
  double descent_m;

  AltitudeReach(const References& references, double damping)
      : climb_m(2.0 * damping * references.climb_m_per_s / references.altitude_rad_per_s),
        descent_m(2.0 * damping * references.descent_m_per_s / references.altitude_rad_per_s) {}

  /// Both down.
  [[nodiscard]] double Cut(double command_m, double reference_m) const {
    return std::clamp(command_m, reference_m - climb_m, reference_m + descent_m);
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

/// Time constant with which the motors' speeds follow their duty cycles about hover.
[[nodiscard]] double MotorLag_s(const Vehicle& vehicle);

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
  /// Of x, or of y.
  [[nodiscard]] const ReferenceModel& position_reference(std::size_t axis = 0) const {
    return position_[axis];
  }
  [[nodiscard]] double yaw_limit_N_m() const { return yaw_limit_N_m_; }
  /// The gaps to which commands are cut.
  [[nodiscard]] double position_reach_m() const { return position_reach_m_; }
  [[nodiscard]] const AltitudeReach& altitude_reach() const { return altitude_reach_; }
  [[nodiscard]] double motor_lag_share() const { return lag_share_; }

 private:
  [[nodiscard]] TiltCommand Tilt(const FlightCommand& command, const MeasuredState& state);
  MotorValues Duties(double battery_V);
  void SoftenTorques(MotorValues& squares);

  Vehicle vehicle_;
  Gains gains_;
  ControllerOptions options_;
  References references_of_;  // of gains and options
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
  double position_reach_m_;
  AltitudeReach altitude_reach_;
  double lag_share_;                 // of a gap that the motors close in a step
  double expected_rad_per_s_ = 0.0;  // the speed that the motors have by now, on the mean
  bool saturated_ = false;
};

}  // namespace lipoid
