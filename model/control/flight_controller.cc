#include "model/control/flight_controller.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

ReferenceModel AngleReference(const ControllerOptions& options, std::size_t axis, double limit) {
  return axis == 2 ? ReferenceModel(options.yaw_omega_rad_per_s, 1.0, kControlStep_s, limit)
                   : ReferenceModel(options.attitude_omega_rad_per_s,
                                    options.attitude_damping,
                                    kControlStep_s,
                                    limit);
}

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

LoopReference<double> Reference(const ReferenceModel::Output& out) {
  return {out.value, out.rate, out.acceleration};
}

}  // namespace

FlightController::FlightController(Vehicle vehicle, Gains gains, const ControllerOptions& options)
    : vehicle_(std::move(vehicle)),
      gains_(std::move(gains)),
      options_(options),
      down_(options.altitude_omega_rad_per_s, options.altitude_damping, kControlStep_s),
      angles_{AngleReference(options, 0, kNoLimit),
              AngleReference(options, 1, kNoLimit),
              AngleReference(options, 2, kNoLimit)} {}

void FlightController::Reset(const MeasuredState& state,
                             double commanded_speed,
                             double highest_speed) {
  const double hover_squared =
      vehicle_.mass_kg * kGravity_m_per_s2 / (4.0 * vehicle_.thrust_coefficient_N_s2);
  if (options_.saturate && options_.limit_reference) {
    // Half of what the motors can be moved from hover, up or down, before one of them saturates;
    // the other half is for the altitude and the feedback.
    const double margin =
        std::clamp(std::min(hover_squared, highest_speed * highest_speed - hover_squared),
                   0.05 * hover_squared,
                   hover_squared);
    const Wrench<double> most{{4.0 * vehicle_.lever_m() * vehicle_.thrust_coefficient_N_s2 * margin,
                               4.0 * vehicle_.lever_m() * vehicle_.thrust_coefficient_N_s2 * margin,
                               4.0 * vehicle_.torque_coefficient_N_m_s2 * margin},
                              0.0};
    for (std::size_t k = 0; k < 3; ++k) {
      angles_[k] =
          AngleReference(options_, k, 0.5 * most.torque_N_m[k] / vehicle_.inertia_kg_m2[k]);
    }
  }
  down_.Reset(state.position_m[2]);
  for (std::size_t k = 0; k < 3; ++k) angles_[k].Reset(state.angles_rad[k]);
  integrals_ = {};
  const double pseudo_control = kGravity_m_per_s2 - 4.0 * vehicle_.thrust_coefficient_N_s2 *
                                                        commanded_speed * commanded_speed /
                                                        vehicle_.mass_kg;
  if (gains_.altitude.integral > 0.0) integrals_.down = pseudo_control / gains_.altitude.integral;
  saturated_ = false;
}

PerMotor<double> FlightController::Duties(double battery_V) {
  PerMotor<double> duty;
  for (std::size_t i = 0; i < 4; ++i) {
    const double squared = output_.speed_squared[i];
    const double speed = std::sqrt(std::max(squared, 0.0));
    duty[i] = DutyCycle(vehicle_, speed, battery_V);
    saturated_ = saturated_ || squared < 0.0 || duty[i] > 1.0;
    if (options_.saturate) duty[i] = std::clamp(duty[i], 0.0, 1.0);
    if (options_.quantize && options_.saturate) duty[i] = QuantizedDuty(vehicle_, duty[i]);
  }
  return duty;
}

PerMotor<double> FlightController::Step(const FlightCommand& command, const MeasuredState& state) {
  double roll = command.roll_rad;
  double pitch = command.pitch_rad;
  if (command.hold_position) {
    const TiltCommand tilt = PositionControl(gains_.position,
                                             state.angles_rad[2],
                                             state.position_m[0] - command.x_m,
                                             state.position_m[1] - command.y_m,
                                             state.velocity_m_per_s[0],
                                             state.velocity_m_per_s[1]);
    roll = tilt.roll_rad;
    pitch = tilt.pitch_rad;
  }
  references_.down = Reference(down_.Step(-command.altitude_m));
  references_.angles = {Reference(angles_[0].Step(roll)),
                        Reference(angles_[1].Step(pitch)),
                        Reference(angles_[2].Step(command.yaw_rad))};
  const InnerLoopState<double> inner{
      state.position_m[2], state.velocity_m_per_s[2], state.angles_rad, state.body_rates_rad_per_s};
  output_ = InnerLoops(vehicle_, gains_, inner, references_, integrals_);
  saturated_ = false;
  const double voltage = options_.compensate && state.battery_V > 0.0
                             ? state.battery_V              // (5.52)
                             : vehicle_.nominal_voltage_V;  // (3.17)
  const PerMotor<double> duty = Duties(voltage);

  // Anti-windup: while a motor saturates, an integral may shrink but not grow.
  const auto integrate = [&](double& integral, double error) {
    if (saturated_ && options_.saturate && error * integral > 0.0) return;
    integral += kControlStep_s * error;  // (3.61)
  };
  integrate(integrals_.down, output_.down_error);
  for (std::size_t k = 0; k < 3; ++k) integrate(integrals_.angles[k], output_.angle_errors[k]);
  return duty;
}

}  // namespace lipoid
