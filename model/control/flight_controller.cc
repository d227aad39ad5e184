#include "model/control/flight_controller.h"

#include <algorithm>
#include <cmath>

#include "model/control/saturation.h"
#include "model/vehicle/powertrain.h"

namespace lipoid {
namespace {

ReferenceModel AngleReference(const References& references,
                              const ControllerOptions& options,
                              std::size_t axis,
                              double limit) {
  return axis == 2
             ? ReferenceModel(references.yaw_rad_per_s, 1.0, kControlStep_s, limit)
             : ReferenceModel(
                   references.attitude_rad_per_s, options.attitude_damping, kControlStep_s, limit);
}

// Half of the tilt that is allowed; the other half is for errors.
ReferenceModel PositionReference(const References& references, const Gains& gains) {
  const double limit = 0.5 * kGravity_m_per_s2 * gains.position.tilt_limit_rad;
  return {references.position_rad_per_s, 1.0, kControlStep_s, std::max(limit, 1e-3)};
}

constexpr double kNoLimit = std::numeric_limits<double>::infinity();

}  // namespace

double MotorLag_s(const Vehicle& vehicle) {
  const double speed =
      std::sqrt(vehicle.mass_kg * kGravity_m_per_s2 / vehicle.total_thrust_coefficient_N_s2());
  return SpeedConstant_s(WithControllers(vehicle), speed);
}

References ReferencesOf(const References& of_gains, const ControllerOptions& options) {
  const auto given = [](double option, double of_gains_rad_per_s) {
    return option > 0.0 ? option : of_gains_rad_per_s;
  };
  return {
      .altitude_rad_per_s = given(options.altitude_omega_rad_per_s, of_gains.altitude_rad_per_s),
      .attitude_rad_per_s = given(options.attitude_omega_rad_per_s, of_gains.attitude_rad_per_s),
      .yaw_rad_per_s = given(options.yaw_omega_rad_per_s, of_gains.yaw_rad_per_s),
      .position_rad_per_s = given(options.position_omega_rad_per_s, of_gains.position_rad_per_s),
      .climb_m_per_s = given(options.climb_m_per_s, of_gains.climb_m_per_s),
      .descent_m_per_s = given(options.descent_m_per_s, of_gains.descent_m_per_s),
      .speed_m_per_s = given(options.position_speed_m_per_s, of_gains.speed_m_per_s)};
}

Triple<double> AngleReferenceLimits(const Vehicle& vehicle, double highest_speed) {
  constexpr std::array kShare{0.35, 0.35, 0.05};
  const double hover_squared =
      vehicle.mass_kg * kGravity_m_per_s2 / vehicle.total_thrust_coefficient_N_s2();
  const double margin =
      std::clamp(std::min(hover_squared, highest_speed * highest_speed - hover_squared),
                 0.05 * hover_squared,
                 hover_squared);
  const Triple<double> torque_per_square = TorqueReach(vehicle);
  Triple<double> limits;
  for (std::size_t k = 0; k < 3; ++k) {
    limits[k] = kShare[k] * torque_per_square[k] * margin / vehicle.inertia_kg_m2[k];
  }
  return limits;
}

FlightController::FlightController(Vehicle vehicle, Gains gains, const ControllerOptions& options)
    : vehicle_(std::move(vehicle)),
      gains_(std::move(gains)),
      options_(options),
      references_of_(ReferencesOf(gains_.references, options)),
      law_(&FindControlLaw(options.law)),
      down_(references_of_.altitude_rad_per_s, options.altitude_damping, kControlStep_s),
      angles_{AngleReference(references_of_, options, 0, kNoLimit),
              AngleReference(references_of_, options, 1, kNoLimit),
              AngleReference(references_of_, options, 2, kNoLimit)},
      position_{PositionReference(references_of_, gains_),
                PositionReference(references_of_, gains_)},
      pulse_width_(vehicle_.rotor_count(), PulseWidth(vehicle_, options.pwm)),
      speed_squared_(vehicle_.rotor_count(), 0.0),
      position_reach_m_(2.0 * references_of_.speed_m_per_s / references_of_.position_rad_per_s),
      altitude_reach_(references_of_, options.altitude_damping),
      lag_share_(-std::expm1(-kControlStep_s / MotorLag_s(vehicle_))) {}

void FlightController::Reset(const MeasuredState& state,
                             double commanded_speed,
                             double highest_speed) {
  yaw_limit_N_m_ = kNoLimit;
  if (options_.saturate && options_.limit_reference) {
    const Triple<double> limits = AngleReferenceLimits(vehicle_, highest_speed);
    yaw_limit_N_m_ = limits[2] * vehicle_.inertia_kg_m2[2];
    for (std::size_t k = 0; k < 3; ++k) {
      // Of the torque that yaw may have, half is for errors.
      const double share = k == 2 ? 0.5 : 1.0;
      angles_[k] = AngleReference(references_of_, options_, k, share * limits[k]);
    }
  }
  down_.Reset(state.position_m[2]);
  for (std::size_t k = 0; k < 3; ++k) angles_[k].Reset(state.angles_rad[k]);
  for (std::size_t k = 0; k < 2; ++k) position_[k].Reset(state.position_m[k]);
  integrals_ = {};
  expected_rad_per_s_ = commanded_speed;
  const double pseudo_control = kGravity_m_per_s2 - vehicle_.total_thrust_coefficient_N_s2() *
                                                        commanded_speed * commanded_speed /
                                                        vehicle_.mass_kg;
  if (gains_.altitude.integral > 0.0) integrals_.down = pseudo_control / gains_.altitude.integral;
  saturated_ = false;
}

// Thrust goes with the square of the speed. Where the motors are told to become slow and are still
// fast, a difference of the commanded squares becomes a larger one of the thrusts, by the ratio of
// the two speeds: torques would come out several times too large. Small ratios are left alone.
void FlightController::SoftenTorques(MotorValues& squares) {
  constexpr double kNoticed = 1.5;
  double mean = 0.0;
  for (const double square : squares) mean += square;
  mean /= double(squares.size());
  const double commanded = std::sqrt(std::max(mean, 0.0));
  const double share = commanded / expected_rad_per_s_;
  if (share * kNoticed < 1.0) {
    for (double& square : squares) square = mean + kNoticed * share * (square - mean);
  }
  expected_rad_per_s_ += lag_share_ * (commanded - expected_rad_per_s_);
}

MotorValues FlightController::Duties(double battery_V) {
  if (options_.saturate) {
    const double highest_speed = HeldSpeed(vehicle_, battery_V);
    saturated_ = Desaturate(speed_squared_, highest_speed * highest_speed);
  }
  MotorValues squares = speed_squared_;
  if (options_.saturate) SoftenTorques(squares);
  MotorValues duty;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    // Without saturation a negative square still has no root.
    const double speed = std::sqrt(std::max(squares[i], 0.0));
    const double wanted = DutyCycle(vehicle_, speed, battery_V);
    duty.push_back(options_.saturate ? pulse_width_[i](wanted) : wanted);
  }
  return duty;
}

TiltCommand FlightController::Tilt(const FlightCommand& command, const MeasuredState& state) {
  // A critically damped reference settles at omega_0/2 times the gap: a gap that is cut keeps the
  // speed.
  const double reach = position_reach_m_;
  const std::array target{command.x_m, command.y_m};
  std::array<double, 2> error;
  std::array<double, 2> velocity;
  for (std::size_t k = 0; k < 2; ++k) {
    const double from = position_[k].value();
    const auto reference = position_[k].Step(std::clamp(target[k], from - reach, from + reach));
    error[k] = state.position_m[k] - reference.value;
    velocity[k] = state.velocity_m_per_s[k] - reference.rate;
  }
  return PositionControl(
      gains_.position, state.angles_rad[2], error[0], error[1], velocity[0], velocity[1]);
}

MotorValues FlightController::Step(const FlightCommand& command, const MeasuredState& state) {
  const TiltCommand tilt = command.hold_position ? Tilt(command, state)
                                                 : TiltCommand{.roll_rad = command.roll_rad,
                                                               .pitch_rad = command.pitch_rad};
  references_.down = down_.Step(altitude_reach_.Cut(-command.altitude_m, down_.value()));
  references_.angles = {angles_[0].Step(tilt.roll_rad),
                        angles_[1].Step(tilt.pitch_rad),
                        angles_[2].Step(command.yaw_rad)};
  const InnerLoopState<double> inner{
      state.position_m[2], state.velocity_m_per_s[2], state.angles_rad, state.body_rates_rad_per_s};
  output_ = law_->inner_loops(vehicle_, gains_, inner, references_, integrals_);
  // Yaw last: pitching while rolled asks for a yaw torque of which the motors have little, and
  // motors that are pulled apart by pitch and yaw at once roll the vehicle, their thrust being no
  // linear function of the command.
  double& yaw_N_m = output_.wrench.torque_N_m[2];
  const bool yaw_cut = std::abs(yaw_N_m) > yaw_limit_N_m_;
  if (yaw_cut) yaw_N_m = std::copysign(yaw_limit_N_m_, yaw_N_m);
  Allocate<double>(
      vehicle_, output_.wrench, {speed_squared_.data(), speed_squared_.size()});  // (3.13)
  saturated_ = false;
  const double voltage = options_.compensate && state.battery_V > 0.0
                             ? state.battery_V              // (5.52)
                             : vehicle_.nominal_voltage_V;  // (3.17)
  const MotorValues duty = Duties(voltage);

  const auto integrate = [](double& integral, double error, bool saturated) {
    if (MayIntegrate(saturated, integral, error)) integral += kControlStep_s * error;  // (3.61)
  };
  integrate(integrals_.down, output_.down_error, saturated_);
  for (std::size_t k = 0; k < 3; ++k) {
    const bool cut = saturated_ || (k == 2 && yaw_cut);
    integrate(integrals_.angles[k], output_.angle_errors[k], cut);
  }
  return duty;
}

}  // namespace lipoid
