#include "model/flight/simulator.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/integrate/integrate_adaptive.hpp>
#include <boost/numeric/odeint/stepper/controlled_runge_kutta.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_dopri5.hpp>
#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>

#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/flight/coupling.h"
#include "model/flight/flight_clock.h"
#include "model/vehicle/level_flight.h"
#include "model/vehicle/motor.h"

namespace lipoid {
namespace {

namespace odeint = boost::numeric::odeint;

constexpr double kWatched_s = 5.0;  // after each altitude step
constexpr double kTurn_rad = 2.0 * std::numbers::pi;
// A vehicle has lost a place when for so long it tilts as far as it may and only gets further away. A gust that is
// overcome is shorter.
constexpr double kLost_s = 5.0;
constexpr double kAtLimit = 0.99;  // of the tilt, which its reference approaches
constexpr double kHardestTouch_m_per_s = 1.5;
constexpr double kSteepestTouch = 0.7;  // cosine of the tilt
constexpr double kDescent_m_per_s = 0.5;
constexpr double kDegrees = 180.0 / std::numbers::pi;

// Mean square and peaks of the errors, and the extremes of the battery, as the flight goes.
class Metrics {
 public:
  explicit Metrics(std::vector<double> steps)
      : steps_(std::move(steps)), peaks_(steps_.size(), -std::numeric_limits<double>::infinity()) {}

  void Add(double time_s, double altitude_error_m, double pitch_error_rad, double battery_V) {
    ++count_;
    altitude_ += altitude_error_m * altitude_error_m;
    pitch_ += pitch_error_rad * pitch_error_rad;
    lowest_V_ = std::min(lowest_V_, battery_V);
    while (next_ < steps_.size() && time_s >= steps_[next_] - 1e-9) ++next_;
    if (next_ > 0 && time_s <= steps_[next_ - 1] + kWatched_s) {
      peaks_[next_ - 1] = std::max(peaks_[next_ - 1], altitude_error_m);
    }
  }
  void AddPosition(double error_m) {
    ++positions_;
    position_ += error_m * error_m;
    farthest_m_ = std::max(farthest_m_, error_m);
  }
  void Report(FlightResult& result) const {
    const double n = double(std::max<std::size_t>(count_, 1));
    result.mse_altitude_m2 = altitude_ / n;
    result.mse_pitch_deg2 = pitch_ / n * kDegrees * kDegrees;
    result.minimum_voltage_V = lowest_V_;
    if (positions_ > 0) {
      result.mse_position_m2 = position_ / double(positions_);
      result.largest_position_error_m = farthest_m_;
    }
    // Steps that the flight did not live to see have no peak.
    result.peak_altitude_error_m.assign(peaks_.begin(), peaks_.begin() + std::ptrdiff_t(next_));
  }

 private:
  std::vector<double> steps_;
  std::vector<double> peaks_;
  std::size_t next_ = 0;
  std::size_t count_ = 0;
  double altitude_ = 0.0;
  double pitch_ = 0.0;
  std::size_t positions_ = 0;
  double position_ = 0.0;
  double farthest_m_ = 0.0;
  double lowest_V_ = std::numeric_limits<double>::infinity();
};

void CheckSetup(const FlightSetup& setup, const FlightPlan& plan) {
  Require(!plan.commands.empty(), "a plan of at least one command", {});
  Require(plan.duration_s > 0.0, "a positive duration", {{"duration_s", plan.duration_s}});
  if (!setup.simulation.motor_lag && setup.cell) {
    throw OptionError(
        "motor_lag=false needs an ideal source: the speeds of motors without lag depend on the "
        "battery's voltage and it on them. Give --battery ideal --xi X");
  }
  if (setup.simulation.drag || Blows(setup.wind)) RequireDrag(setup.vehicle);
  if (setup.flight_code != nullptr) RequireQuadX(setup.vehicle, "flight code from outside");
  // Runge-Kutta of fourth order is stable up to 2.78 time constants; half of it is accurate.
  const double dt_s = kControlStep_s / setup.simulation.substeps;
  const Vehicle driven = WithControllers(setup.vehicle);
  const auto follow = [&](std::string_view what, double constant_s) {
    if (setup.simulation.integrator != Integrator::kRk4 || dt_s <= 1.4 * constant_s) return;
    const double substeps = std::ceil(kControlStep_s / (1.4 * constant_s));
    throw OptionError(fmt::format(
        "the {} of {} has a time constant of {:.3g} s, steps of {:.3g} s cannot follow it. {}",
        what,
        setup.vehicle.name,
        constant_s,
        dt_s,
        substeps > kMostSubsteps ? std::string("Look at the units of its numbers")
                                 : fmt::format("Give --set simulation.substeps={} or more, or "
                                               "simulation.integrator=dormand-prince",
                                               substeps)));
  };
  if (driven.armature_inductance_H > 0.0)
    follow("armature current", driven.armature_inductance_H / driven.armature_resistance_Ohm);
  if (setup.simulation.motor_lag) {
    const double supply_V =
        setup.cell ? setup.cell->series * setup.cell->open_circuit_voltage(setup.initial_soc)
                   : setup.xi * driven.nominal_voltage_V;
    follow("motors' speed",
           SpeedConstant_s(driven,
                           std::max(HoverByCoefficients(driven).speed_rad_per_s,
                                    HeldSpeed(driven, std::max(supply_V, 0.0)))));
  }
  if (setup.cell) CheckStart(setup.initial_soc);
}

// Follows the plan, and leaves it for the ground when the battery is low.
class Pilot {
 public:
  explicit Pilot(const FlightPlan& plan) : plan_(plan) {}

  [[nodiscard]] FlightCommand At(double time_s) {
    FlightCommand command = plan_.At(time_s);
    if (landing_) {
      target_m_ -= kDescent_m_per_s * kControlStep_s;
      command.altitude_m = std::max(target_m_, -0.2);
      command.roll_rad = 0.0;
      command.pitch_rad = 0.0;
      if (command.hold_position) {
        command.x_m = x_m_;
        command.y_m = y_m_;
      }
    }
    return command;
  }
  void Land(double altitude_m, double x_m, double y_m) {
    landing_ = true;
    target_m_ = altitude_m;
    x_m_ = x_m;
    y_m_ = y_m;
  }
  [[nodiscard]] bool landing() const { return landing_; }

 private:
  PlanFollower plan_;
  bool landing_ = false;
  double target_m_ = 0.0;
  double x_m_ = 0.0;
  double y_m_ = 0.0;
};

template <std::size_t R, std::size_t N>
class Simulation {
 public:
  Simulation(const FlightSetup& setup, const FlightPlan& plan)
      : setup_(setup),
        plan_(plan),
        pilot_(plan),
        plant_(setup.vehicle,
               {.motor_lag = setup.simulation.motor_lag,
                .drag = setup.simulation.drag || Blows(setup.wind),
                .ground = setup.simulation.ground}),
        controller_(setup.vehicle, setup.gains, FlownController(setup)),
        metrics_(plan.AltitudeSteps()) {
    if (setup.cell) battery_.emplace(*setup.cell, setup.initial_soc, setup.ambient_degC);
    if (Blows(setup.wind)) wind_.emplace(setup.wind, setup.seed);
    inputs_.supply = {setup.xi * setup.vehicle.nominal_voltage_V, 0.0};
    Start();
  }

  FlightResult Run(const FlightRecorder& record, const FlightProgress& progress) {
    const auto begin = std::chrono::steady_clock::now();
    const auto steps = static_cast<std::size_t>(std::llround(plan_.duration_s / kControlStep_s));
    for (std::size_t k = 0; k < steps && !ended_; ++k) {
      time_s_ = double(k) * kControlStep_s;
      ControlStep(record);
      Integrate();
      ++result_.steps;
      Judge();
      if (progress && k % 1000 == 0) progress(double(k) / double(steps));
    }
    result_.wall_s =
        std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    result_.simulated_s = double(result_.steps) * kControlStep_s;
    const auto electrical = plant_.ElectricalAt(x_, inputs_);
    result_.charge_C = x_[kCharge];
    result_.final_voltage_V = electrical.battery_V;
    result_.final_soc = Soc();
    result_.rest_soc = battery_ ? battery_->rest_soc() : std::numeric_limits<double>::quiet_NaN();
    if (setup_.Warms()) result_.final_temperature_degC = battery_->temperature_degC();
    metrics_.Report(result_);
    result_.minimum_voltage_V = std::min(result_.minimum_voltage_V, result_.final_voltage_V);
    if (result_.steps > 0) result_.saturated_share = double(saturated_) / double(result_.steps);
    JudgeCourse();
    return result_;
  }

 private:
  void Start() {
    const bool compensate = setup_.controller.compensate;
    result_.trim = battery_ ? HoverTrim(setup_.vehicle, *battery_, compensate)
                            : HoverTrim(setup_.vehicle, inputs_.supply, compensate);
    if (battery_) inputs_.supply = battery_->Linearize();
    const Trim& trim = result_.trim;
    const FlightCommand& first = plan_.commands.front().command;
    x_.fill(0.0);
    x_[plant::kPosition] = first.x_m;
    x_[plant::kPosition + 1] = first.y_m;
    x_[plant::kPosition + 2] = -first.altitude_m;
    x_[plant::kAngles + 2] = first.yaw_rad;
    for (std::size_t i = 0; i < R; ++i) {
      x_[plant::kSpeeds + i] = trim.speed_rad_per_s;
      if constexpr (N > plant::States(R)) x_[plant::Currents(R) + i] = trim.motor_A;
      inputs_.duty[i] = setup_.controller.saturate ? std::min(trim.duty, 1.0) : trim.duty;
    }
    const MeasuredState measured = Truth(trim.battery_V);
    if (setup_.estimate) StartEstimating(measured);
    // A cell will be nearly empty one day: references must be within the motors' reach then too.
    const double lowest_V = battery_ ? battery_->cutoff_V() : trim.battery_V;
    controller_.Reset(
        measured, trim.commanded_speed_rad_per_s, HeldSpeed(setup_.vehicle, lowest_V));
    if (setup_.flight_code != nullptr) setup_.flight_code->Reset(measured);
  }

  // The biases are found at rest, where the specific force is that of hover.
  void StartEstimating(const MeasuredState& at_rest) {
    sensors_.emplace(setup_.sensors, setup_.seed);
    estimator_.emplace(setup_.estimator);
    const SensedMotion rest{.position_m = at_rest.position_m,
                            .angles_rad = at_rest.angles_rad,
                            .specific_force_m_per_s2 = {0.0, 0.0, -kGravity_m_per_s2},
                            .battery_V = at_rest.battery_V};
    std::vector<SensorReadings> readings;
    for (int k = 0; k < setup_.estimator.calibration_samples; ++k) {
      readings.push_back(sensors_->Read(rest));
    }
    estimator_->Reset(at_rest, readings);
    if (setup_.flight_code != nullptr) setup_.flight_code->ResetEstimator(at_rest, readings);
  }

  [[nodiscard]] MeasuredState Truth(double battery_V) const {
    return {TripleAt(x_, plant::kPosition),
            TripleAt(x_, plant::kVelocity),
            TripleAt(x_, plant::kAngles),
            TripleAt(x_, plant::kRates),
            battery_V};
  }

  [[nodiscard]] MeasuredState Measure() {
    const MeasuredState truth = Truth(plant_.ElectricalAt(x_, inputs_).battery_V);
    if (!estimator_) return truth;
    const SensorReadings readings =
        sensors_->Read({.position_m = truth.position_m,
                        .angles_rad = truth.angles_rad,
                        .velocity_m_per_s = truth.velocity_m_per_s,
                        .body_rates_rad_per_s = truth.body_rates_rad_per_s,
                        .specific_force_m_per_s2 = SpecificForce(plant_, x_, inputs_),
                        .battery_V = truth.battery_V});
    return setup_.flight_code != nullptr ? setup_.flight_code->Estimate(readings)
                                         : estimator_->Step(readings);
  }
  [[nodiscard]] double Soc() const {
    return battery_ ? battery_->soc() : std::numeric_limits<double>::quiet_NaN();
  }

  void ControlStep(const FlightRecorder& record) {
    // The voltage is sampled before the new duty cycles take effect.
    const MeasuredState measured = Measure();
    command_ = pilot_.At(time_s_);
    SetDuties(controller_.Step(command_, measured));
    if constexpr (R == 4) {
      if (setup_.flight_code != nullptr)
        inputs_.duty = setup_.flight_code->Step(command_, measured);
    }
    if (battery_ && battery_->bends()) FollowTheCurrent(plant_, x_, inputs_, *battery_);
    if (wind_) inputs_.wind_m_per_s = WindOn(x_, *wind_);
    saturated_ += controller_.saturated() ? 1 : 0;
    const auto electrical = plant_.ElectricalAt(x_, inputs_);
    battery_V_ = electrical.battery_V;
    const auto& reference = controller_.references();
    metrics_.Add(time_s_,
                 x_[plant::kPosition + 2] - reference.down.value,
                 reference.angles[1].value - x_[plant::kAngles + 1],
                 battery_V_);
    WatchAltitude(x_[plant::kPosition + 2] - reference.down.value);
    if (command_.hold_position) WatchPlace();
    if (record) record(Sample(measured, electrical));
  }

  void SetDuties(const MotorValues& duties) {
    for (std::size_t i = 0; i < R; ++i) inputs_.duty[i] = duties[i];
  }

  [[nodiscard]] FlightSample Sample(const MeasuredState& measured,
                                    const Electrical<double, R>& electrical) const {
    const auto& reference = controller_.references();
    FlightSample s;
    s.time_s = time_s_;
    s.position_m = {x_[0], x_[1], -x_[2]};
    s.velocity_m_per_s = {
        x_[plant::kVelocity], x_[plant::kVelocity + 1], -x_[plant::kVelocity + 2]};
    s.angles_rad = TripleAt(x_, plant::kAngles);
    s.body_rates_rad_per_s = TripleAt(x_, plant::kRates);
    s.altitude_reference_m = -reference.down.value;
    s.angle_references_rad = {
        reference.angles[0].value, reference.angles[1].value, reference.angles[2].value};
    s.position_command_m = {command_.x_m, command_.y_m, command_.altitude_m};
    s.altitude_estimate_m = -measured.position_m[2];
    s.angle_estimates_rad = measured.angles_rad;
    s.speed_rad_per_s.assign(electrical.speed_rad_per_s.begin(), electrical.speed_rad_per_s.end());
    s.duty.assign(inputs_.duty.begin(), inputs_.duty.end());
    s.current_A.assign(electrical.current_A.begin(), electrical.current_A.end());
    s.battery_V = electrical.battery_V;
    s.battery_A = electrical.battery_A;
    s.soc = Soc();
    if (setup_.Warms()) s.temperature_degC = battery_->temperature_degC();
    return s;
  }

  void Integrate() {
    const int substeps = setup_.simulation.substeps;
    const double dt_s = kControlStep_s / substeps;
    const auto derivative = [this](const State& x, State& dx, double) {
      plant_.Derivative(x, inputs_, dx);
    };
    for (int k = 0; k < substeps; ++k) {
      if (battery_) inputs_.supply = battery_->Linearize();
      const double before_C = x_[kCharge];
      if (setup_.simulation.integrator == Integrator::kRk4) {
        rk4_.do_step(derivative, x_, 0.0, dt_s);
      } else {
        odeint::integrate_adaptive(
            odeint::make_controlled(
                setup_.simulation.tolerance, setup_.simulation.tolerance, DormandPrince()),
            derivative,
            x_,
            0.0,
            dt_s,
            dt_s);
      }
      if (battery_) battery_->Advance(x_[kCharge] - before_C, dt_s);
    }
    // The slots of motors without lag show what (5.10) gives.
    if (!setup_.simulation.motor_lag) {
      const auto electrical = plant_.ElectricalAt(x_, inputs_);
      for (std::size_t i = 0; i < R; ++i) x_[plant::kSpeeds + i] = electrical.speed_rad_per_s[i];
    }
  }

  // Notes when tilting as far as it may no longer keeps the vehicle from drifting off.
  void WatchPlace() {
    const double off_m =
        std::hypot(x_[plant::kPosition] - controller_.position_reference(0).value(),
                   x_[plant::kPosition + 1] - controller_.position_reference(1).value());
    metrics_.AddPosition(off_m);
    for (const std::size_t k : {0U, 1U}) {
      // The larger one; of NaN and a number the number.
      result_.fastest_m_per_s =
          std::fmax(result_.fastest_m_per_s, std::abs(x_[plant::kVelocity + k]));
      result_.fastest_reference_m_per_s = std::fmax(
          result_.fastest_reference_m_per_s, std::abs(controller_.position_reference(k).rate()));
    }
    if (lost_) return;
    const auto& angles = controller_.references().angles;
    const double tilt_rad = std::max(std::abs(angles[0].value), std::abs(angles[1].value));
    if (tilt_rad < kAtLimit * setup_.gains.position.tilt_limit_rad) {
      at_limit_.reset();
    } else if (!at_limit_) {
      at_limit_ = AtLimit{time_s_, off_m};
    } else if (time_s_ - at_limit_->since_s >= kLost_s) {
      lost_ = off_m > std::max(at_limit_->off_m, kAtPlace_m);
      if (!lost_) at_limit_ = AtLimit{time_s_, off_m};
    }
  }

  // Of the last kLost_s: root mean square.
  [[nodiscard]] double RecentAltitudeError() const {
    double sum = 0.0;
    for (const double square : altitude_m2_) sum += square;
    return std::sqrt(sum / double(std::max<std::size_t>(altitude_m2_.size(), 1)));
  }

  void WatchAltitude(double off_m) {
    constexpr auto kSteps = std::size_t(kLost_s / kControlStep_s);
    if (altitude_m2_.size() < kSteps) {
      altitude_m2_.push_back(off_m * off_m);
    } else {
      altitude_m2_[result_.steps % kSteps] = off_m * off_m;
    }
  }

  void WatchArrivals(double now_s) {
    auto& distances_m = result_.waypoint_distance_m;
    while (distances_m.size() < plan_.arrivals_s.size() &&
           now_s >= plan_.arrivals_s[distances_m.size()] - kRounding_s) {
      const FlightCommand& place = plan_.commands[distances_m.size()].command;
      distances_m.push_back(std::hypot(x_[plant::kPosition] - place.x_m,
                                       x_[plant::kPosition + 1] - place.y_m,
                                       x_[plant::kPosition + 2] + place.altitude_m));
      result_.waypoint_heading_error_rad.push_back(
          std::abs(std::remainder(x_[plant::kAngles + 2] - place.yaw_rad, kTurn_rad)));
    }
  }

  // A flight whose vehicle was not where it should be is not completed.
  void JudgeCourse() {
    std::vector<std::string> reasons;
    if (lost_) {
      reasons.push_back(fmt::format(
          "it could not hold its place: from {:.3f} s on it tilted by the {:.3g} "
          "degrees that it may and drifted off all the same, up to {:.4g} m. Give {}",
          at_limit_->since_s,
          setup_.gains.position.tilt_limit_rad * kDegrees,
          result_.largest_position_error_m,
          Blows(setup_.wind)
              ? "less wind, or gains with a larger tilt_limit_rad"
              : "gains that are placed for this vehicle, commands that are compensated for the "
                "voltage, or a smaller change of altitude on the way"));
    }
    if (result_.outcome == Outcome::kCompleted) {
      const double off_m = RecentAltitudeError();
      if (!(off_m <= kAtPlace_m)) {
        reasons.push_back(fmt::format(
            "it could not hold its altitude: over the last {:g} s it was {:.4g} m (rms) from where its "
            "reference was{}",
            std::min(kLost_s, result_.simulated_s),
            off_m,
            result_.trim.possible() ? "" : ", for it cannot hover on this battery"));
      }
    }
    const auto& distances_m = result_.waypoint_distance_m;
    std::vector<std::size_t> missed;
    for (std::size_t k = 0; k < distances_m.size(); ++k) {
      if (Missed(k)) missed.push_back(k);
    }
    if (!missed.empty()) {
      const std::size_t worst =
          *std::max_element(missed.begin(), missed.end(), [&](std::size_t a, std::size_t b) {
            return distances_m[a] < distances_m[b];
          });
      reasons.push_back(fmt::format(
          "it missed {} of {}: {:.4g} m were left to waypoint {} at the end of its "
          "stay. Give a longer stay_s (of a square: corner_s), which begins with the command and includes the "
          "way",
          missed.size(),
          Counted(distances_m.size(), "waypoint"),
          distances_m[worst],
          worst + 1));
    }
    const auto& left_rad = result_.waypoint_heading_error_rad;
    for (std::size_t k = 0; k < left_rad.size(); ++k) {
      if (!NotTurned(k)) continue;
      reasons.push_back(fmt::format(
          "it had not turned: {:.3g} degrees were left to the heading of waypoint {} at the end of its stay. Give "
          "a longer stay_s, or a smaller turn",
          left_rad[k] * kDegrees,
          k + 1));
      break;
    }
    if (reasons.empty()) return;
    if (!result_.reason.empty()) reasons.insert(reasons.begin(), result_.reason);
    if (result_.outcome == Outcome::kCompleted) result_.outcome = Outcome::kOffCourse;
    result_.reason = fmt::format("{}", fmt::join(reasons, "; "));
  }

  // Of a short way half is not there yet.
  [[nodiscard]] bool Missed(std::size_t k) const {
    double reach_m = kAtPlace_m;
    if (k > 0) {
      const FlightCommand& from = plan_.commands[k - 1].command;
      const FlightCommand& to = plan_.commands[k].command;
      const double way_m =
          std::hypot(to.x_m - from.x_m, to.y_m - from.y_m, to.altitude_m - from.altitude_m);
      if (way_m > 0.0) reach_m = std::min(reach_m, 0.5 * way_m);
    }
    return result_.waypoint_distance_m[k] > reach_m;
  }

  // The heading that an estimator takes drifts: what counts is a turn of which more than half is left.
  [[nodiscard]] bool NotTurned(std::size_t k) const {
    if (k == 0) return false;
    const double turn_rad = std::abs(std::remainder(
        plan_.commands[k].command.yaw_rad - plan_.commands[k - 1].command.yaw_rad, kTurn_rad));
    return turn_rad > kTurn_rad / 36.0 && result_.waypoint_heading_error_rad[k] > 0.5 * turn_rad;
  }

  void End(Outcome outcome, std::string reason) {
    if (ended_) return;
    ended_ = true;
    result_.outcome = outcome;
    result_.reason = std::move(reason);
  }

  // Whether the flight goes on.
  void Judge() {
    const double now_s = time_s_ + kControlStep_s;
    for (const double value : x_) {
      if (!std::isfinite(value)) {
        return End(Outcome::kCrashed,
                   fmt::format("the state is not finite at {:.3f} s: the loop is unstable, or the "
                               "step too long",
                               now_s));
      }
    }
    const double pitch = x_[plant::kAngles + 1];
    if (!(std::abs(pitch) < kGimbalLock_rad)) {
      return End(Outcome::kCrashed,
                 fmt::format("it stood on its nose at {:.3f} s: at a pitch of 90 degrees Euler "
                             "angles end (gimbal lock)",
                             now_s));
    }
    if (setup_.simulation.ground) JudgeGround(now_s);
    if (battery_) JudgeBattery(now_s);
    if (!pilot_.landing()) WatchArrivals(now_s);
  }

  void JudgeGround(double now_s) {
    if (!NearGround(setup_.vehicle, x_[plant::kPosition + 2])) return;
    const Attitude<double> attitude(TripleAt(x_, plant::kAngles));
    // Of the four feet the lowest, in inertial axes.
    const double reach =
        setup_.vehicle.lever_m() *
        (std::abs(attitude.sin_pitch) + std::abs(attitude.cos_pitch * attitude.sin_roll));
    if (x_[plant::kPosition + 2] + reach <= 0.0) return;
    const double speed = x_[plant::kVelocity + 2];
    const double upright = attitude.cos_roll * attitude.cos_pitch;
    if (speed > kHardestTouch_m_per_s || upright < kSteepestTouch) {
      return End(Outcome::kCrashed,
                 fmt::format("it hit the ground at {:.3f} s with {:.2f} m/s, tilted by {:.0f} "
                             "degrees",
                             now_s,
                             speed,
                             std::acos(std::clamp(upright, -1.0, 1.0)) * kDegrees));
    }
    if (!pilot_.landing()) {
      return End(Outcome::kCrashed,
                 fmt::format("it touched the ground at {:.3f} s with {:.2f} m/s while {:.2f} m "
                             "were commanded",
                             now_s,
                             speed,
                             command_.altitude_m));
    }
    if (std::abs(speed) < 0.05) {
      result_.landed_s = now_s;
      End(Outcome::kCompleted, fmt::format("landed at {:.3f} s: the battery was low", now_s));
    }
  }

  void JudgeBattery(double now_s) {
    if (battery_->soc() <= 0.0) {
      return End(Outcome::kBatteryEmpty,
                 fmt::format("the state of charge reached 0 at {:.3f} s", now_s));
    }
    below_cutoff_s_ = battery_V_ < battery_->cutoff_V() ? below_cutoff_s_ + kControlStep_s : 0.0;
    if (EmptyAfter(below_cutoff_s_)) {
      return End(
          Outcome::kBatteryEmpty,
          fmt::format(
              "the battery was below {} V for a second at {:.3f} s", battery_->cutoff_V(), now_s));
    }
    low_s_ = battery_V_ < setup_.land_below_V ? low_s_ + kControlStep_s : 0.0;
    if (EmptyAfter(low_s_) && !pilot_.landing()) {
      pilot_.Land(-x_[plant::kPosition + 2], x_[0], x_[1]);
    }
  }

  static constexpr std::size_t kCharge = plant::Charge(R);
  using State = PlantState<double, N>;
  using DormandPrince =
      odeint::runge_kutta_dopri5<State, double, State, double, odeint::array_algebra>;

  const FlightSetup& setup_;
  const FlightPlan& plan_;
  Pilot pilot_;
  RotorPlant<R> plant_;
  FlightController controller_;
  Metrics metrics_;
  std::optional<BatterySupply> battery_;
  std::optional<Wind> wind_;
  std::optional<Sensors> sensors_;
  std::optional<Estimator> estimator_;
  odeint::runge_kutta4<State, double, State, double, odeint::array_algebra> rk4_;

  State x_{};
  PlantInputs<double, R> inputs_;
  FlightCommand command_;
  FlightResult result_;
  double time_s_ = 0.0;
  double battery_V_ = 0.0;
  double below_cutoff_s_ = 0.0;
  double low_s_ = 0.0;
  struct AtLimit {
    double since_s;
    double off_m;
  };
  std::optional<AtLimit> at_limit_;  // of the tilt
  bool lost_ = false;
  std::size_t saturated_ = 0;
  std::vector<double> altitude_m2_;  ///< squared errors of the last kLost_s, in no order
  bool ended_ = false;
};

}  // namespace

void CheckStart(double initial_soc) {
  constexpr double kFullest = 1.1;  // what a charger that is a tenth of a volt too high leaves
  if (initial_soc > 0.0 && initial_soc <= kFullest) return;
  throw OptionError(
      fmt::format("the cell is {} at a state of charge of {}: {}. Give --initial-soc "
                  "between 0 and 1",
                  initial_soc > 0.0 ? "beyond full" : "empty",
                  initial_soc,
                  initial_soc > 0.0 ? "no charger leaves it so" : "nothing to fly with"));
}

ControllerOptions FlownController(const FlightSetup& setup) {
  ControllerOptions options = setup.controller;
  if (setup.estimate && setup.flight_code == nullptr && options.attitude_omega_rad_per_s == 0.0) {
    options.attitude_omega_rad_per_s =
        std::min(setup.gains.references.attitude_rad_per_s,
                 1.0 / (MotorLag_s(setup.vehicle) + 0.5 * kControlStep_s));
  }
  return options;
}

FlightResult Fly(const FlightSetup& setup,
                 const FlightPlan& plan,
                 const FlightRecorder& record,
                 const FlightProgress& progress) {
  CheckSetup(setup, plan);
  return ForRotorsOf(setup.vehicle, [&](auto rotors) {
    constexpr std::size_t kRotors = rotors;
    if (setup.vehicle.armature_inductance_H > 0.0) {
      return Simulation<kRotors, plant::StatesWithInductance(kRotors)>(setup, plan)
          .Run(record, progress);
    }
    return Simulation<kRotors, plant::States(kRotors)>(setup, plan).Run(record, progress);
  });
}

}  // namespace lipoid
