#pragma once

/// @file
/// The altitude and the pitch loop alone, as gain design runs them thousands of times: the same
/// motors, speed controllers, references, saturation and anti-windup as the whole flight on an ideal
/// source, without the states that rest (a test holds them against the whole). PWM is continuous. T is
/// double, or an automatic-differentiation scalar that carries the gains.
///
/// The integral enters as the product K_eI e_I, which starts where it holds the hover of its xi,
/// for K_eI = 0 too. Tests: tests/identify/gains/reduced_loops_test.cc.

#include <algorithm>
#include <array>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "model/control/flight_controller.h"
#include "model/control/saturation.h"
#include "model/core/errors.h"
#include "model/flight/flight_plan.h"
#include "model/flight/trim.h"

namespace lipoid {

/// One loop's task at one xi.
struct LoopTask {
  Vehicle vehicle;
  double xi = 1.0;
  ControllerOptions controller;
  FlightPlan plan;  ///< altitude, or pitch in commands without position
  bool motor_lag = true;
  References references = {};  ///< of the gains, where the controller's options have none
};

/// What a plan commands at the start of every control step.
[[nodiscard]] std::vector<FlightCommand> SampledCommands(const FlightPlan& plan);

namespace reduced {

template <class State>
using Rk4 = boost::numeric::odeint::
    runge_kutta4<State, double, State, double, boost::numeric::odeint::array_algebra>;

/// K_eI e_I + K_e e + K_edot e' + y_ref'', and the integral's next value.
template <class T>
class ErrorLoop {
 public:
  ErrorLoop(const BasicErrorGains<T>& gains, double integral_term)
      : gains_(gains), integral_term_(T(integral_term)) {}

  [[nodiscard]] T PseudoControl(const LoopReference<double>& reference,
                                const T& error,
                                const T& rate) const {
    return T(reference.acceleration) + integral_term_ + gains_.proportional * error +
           gains_.derivative * (T(reference.rate) - rate);  // (3.60)
  }
  void Integrate(bool saturated, const T& error) {
    if (MayIntegrate(saturated, integral_term_, error)) {
      integral_term_ = integral_term_ + kControlStep_s * (gains_.integral * error);  // (3.61)
    }
  }

 private:
  BasicErrorGains<T> gains_;
  T integral_term_;  // K_eI e_I
};

/// The duty cycle of a square >= 0; its slope at 0 is none of interest.
template <class T>
T DutyOfSquare(const Vehicle& vehicle, const T& squared) {
  using std::sqrt;
  if (!(ScalarPart(squared) > 0.0)) return T(0.0);
  return DutyCycle(vehicle, T(sqrt(squared)), T(vehicle.nominal_voltage_V));  // (3.17)
}

/// `driven` is WithControllers(); drive_V is DriveVoltage().
template <class T>
T MotorAcceleration(const Vehicle& driven, const T& drive_V, const T& speed) {
  const T current_A = ArmatureCurrent(driven, drive_V, speed);
  const bool through_diodes = !driven.esc.synchronous && ScalarPart(current_A) < 0.0;
  return RotorAcceleration(driven, through_diodes ? T(0.0) : current_A, speed);
}

}  // namespace reduced

/// Calls visit(k, error) with the altitude error e_Z at the start of every control step, all motors
/// alike.
template <class T, class Visit>
void RunAltitudeLoop(const LoopTask& task,
                     const std::vector<FlightCommand>& commands,
                     const BasicErrorGains<T>& gains,
                     Visit&& visit) {
  using State = std::array<T, 3>;  // Z, W, omega
  const Vehicle v = EquivalentQuadrotor(task.vehicle);
  const Vehicle driven = WithControllers(v);
  const double source_V = task.xi * v.nominal_voltage_V;
  const Trim trim = HoverTrim(v, Supply<double>{source_V, 0.0});
  const double highest = HeldSpeed(v, v.nominal_voltage_V);
  const double limit = highest * highest;
  const double thrust = 4.0 * v.thrust_coefficient_N_s2;
  const double trim_square = trim.commanded_speed_rad_per_s * trim.commanded_speed_rad_per_s;

  const References references = ReferencesOf(task.references, task.controller);
  ReferenceModel reference(
      references.altitude_rad_per_s, task.controller.altitude_damping, kControlStep_s);
  const AltitudeReach reach(references, task.controller.altitude_damping);
  const double start_m = -commands.front().altitude_m;
  reference.Reset(start_m);
  reduced::ErrorLoop<T> loop(gains, kGravity_m_per_s2 - thrust * trim_square / v.mass_kg);
  State x{T(start_m), T(0.0), T(trim.speed_rad_per_s)};
  T drive_V(0.0);
  const auto derivative = [&](const State& at, State& rate, double) {
    const T speed = task.motor_lag ? at[2] : HeldSpeed(driven, drive_V);
    rate[0] = at[1];
    rate[1] = T(kGravity_m_per_s2) - (thrust / v.mass_kg) * (speed * speed);  // (3.51)
    rate[2] = task.motor_lag ? reduced::MotorAcceleration(driven, drive_V, speed) : T(0.0);
  };
  reduced::Rk4<State> stepper;
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const auto now = reference.Step(reach.Cut(-commands[k].altitude_m, reference.value()));
    const T error = T(now.value) - x[0];
    visit(k, error);
    const T nu = loop.PseudoControl(now, error, x[1]);
    std::array<T, 1> square{(v.mass_kg / thrust) * (T(kGravity_m_per_s2) - nu)};  // (5.18)
    const bool saturated = task.controller.saturate && Desaturate(square, limit);
    drive_V = DriveVoltage(v.esc, reduced::DutyOfSquare(v, square[0]), T(source_V));
    loop.Integrate(saturated, error);
    stepper.do_step(derivative, x, 0.0, kControlStep_s);
  }
}

namespace reduced {

/// Rotors that stand as far ahead of the middle are alike in a pitch.
struct PitchGroup {
  double ahead = 0.0;   ///< over the arm
  double shares = 0.0;  ///< of thrust, of all its rotors
};

/// By falling `ahead`.
[[nodiscard]] std::vector<PitchGroup> PitchGroupsOf(const Vehicle& vehicle);

template <std::size_t G, class T, class Visit>
void RunPitchLoop(const LoopTask& task,
                  const std::vector<PitchGroup>& groups,
                  const std::vector<FlightCommand>& commands,
                  const ErrorGains& altitude_gains,
                  const BasicErrorGains<T>& gains,
                  Visit&& visit) {
  using std::cos;
  using State = std::array<T, 4 + G>;  // Z, W, Theta, q, omega of each group
  const Vehicle& v = task.vehicle;
  const Vehicle driven = WithControllers(v);
  const double source_V = task.xi * v.nominal_voltage_V;
  const Trim trim = HoverTrim(v, Supply<double>{source_V, 0.0});
  const double highest = HeldSpeed(v, v.nominal_voltage_V);
  const double limit = highest * highest;
  const double k_T = v.thrust_coefficient_N_s2;
  const double trim_square = trim.commanded_speed_rad_per_s * trim.commanded_speed_rad_per_s;
  const bool limited = task.controller.saturate && task.controller.limit_reference;
  // The other laws are linear about hover.
  const bool inverts = task.controller.law == "inversion";

  const References references = ReferencesOf(task.references, task.controller);
  ReferenceModel height(
      references.altitude_rad_per_s, task.controller.altitude_damping, kControlStep_s);
  ReferenceModel pitch(references.attitude_rad_per_s,
                       task.controller.attitude_damping,
                       kControlStep_s,
                       limited ? AngleReferenceLimits(v, HeldSpeed(v, source_V))[1]
                               : std::numeric_limits<double>::infinity());
  const AltitudeReach reach(references, task.controller.altitude_damping);
  const double start_m = -commands.front().altitude_m;
  height.Reset(start_m);
  pitch.Reset(0.0);
  const BasicErrorGains<T> held{
      T(altitude_gains.proportional), T(altitude_gains.integral), T(altitude_gains.derivative)};
  const RotorSums sums = v.SumsOverRotors();
  ErrorLoop<T> height_loop(held, kGravity_m_per_s2 - sums.thrust * k_T * trim_square / v.mass_kg);
  ErrorLoop<T> pitch_loop(gains, 0.0);
  State x;
  x.fill(T(0.0));
  x[0] = T(start_m);
  std::fill(x.begin() + 4, x.end(), T(trim.speed_rad_per_s));
  std::array<T, G> drive_V;
  drive_V.fill(T(0.0));
  const auto derivative = [&](const State& at, State& rate, double) {
    T thrust_squares(0.0);
    T pitch_squares(0.0);
    for (std::size_t g = 0; g < G; ++g) {
      const T speed = task.motor_lag ? at[4 + g] : HeldSpeed(driven, drive_V[g]);
      const T squares = groups[g].shares * (speed * speed);
      thrust_squares = thrust_squares + squares;
      pitch_squares = pitch_squares + groups[g].ahead * squares;
      rate[4 + g] = task.motor_lag ? MotorAcceleration(driven, drive_V[g], speed) : T(0.0);
    }
    rate[0] = at[1];
    rate[1] = T(kGravity_m_per_s2) - (k_T / v.mass_kg) * thrust_squares * cos(at[2]);  // (3.51)
    rate[2] = at[3];
    rate[3] = (k_T * v.arm_m / v.inertia_kg_m2[1]) * pitch_squares;
  };
  Rk4<State> stepper;
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const auto down = height.Step(reach.Cut(-commands[k].altitude_m, height.value()));
    const auto tilt = pitch.Step(commands[k].pitch_rad);
    const T height_error = T(down.value) - x[0];
    const T error = T(tilt.value) - x[2];
    visit(k, error);
    T thrust =
        v.mass_kg * (T(kGravity_m_per_s2) - height_loop.PseudoControl(down, height_error, x[1]));
    if (inverts) thrust = thrust / cos(x[2]);                                           // (3.58)
    const T torque = v.inertia_kg_m2[1] * pitch_loop.PseudoControl(tilt, error, x[3]);  // (3.49)
    const T common = (1.0 / (k_T * sums.thrust)) * thrust;
    const T difference = (1.0 / (k_T * v.arm_m * sums.ahead_squared)) * torque;
    std::array<T, G> square;
    for (std::size_t g = 0; g < G; ++g)
      square[g] = common + groups[g].ahead * difference;  // (3.13)
    const bool saturated = task.controller.saturate && Desaturate(square, limit);
    for (std::size_t g = 0; g < G; ++g)
      drive_V[g] = DriveVoltage(v.esc, DutyOfSquare(v, square[g]), T(source_V));
    height_loop.Integrate(saturated, height_error);
    pitch_loop.Integrate(saturated, error);
    stepper.do_step(derivative, x, 0.0, kControlStep_s);
  }
}

}  // namespace reduced

/// The same of the pitch error e_Theta. The altitude loop runs along with gains of its own: they share
/// the motors.
template <class T, class Visit>
void RunPitchLoop(const LoopTask& task,
                  const std::vector<FlightCommand>& commands,
                  const ErrorGains& altitude_gains,
                  const BasicErrorGains<T>& gains,
                  Visit&& visit) {
  const auto groups = reduced::PitchGroupsOf(task.vehicle);
  const auto run = [&]<std::size_t G>() {
    reduced::RunPitchLoop<G>(task, groups, commands, altitude_gains, gains, visit);
  };
  switch (groups.size()) {
    case 2:
      return run.template operator()<2>();
    case 3:
      return run.template operator()<3>();
    case 4:
      return run.template operator()<4>();
    case 5:
      return run.template operator()<5>();
    default:
      Require(false, "a layout with two to five groups of rotors ahead of one another");
  }
}

}  // namespace lipoid
