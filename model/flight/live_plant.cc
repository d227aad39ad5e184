#include "model/flight/live_plant.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/numeric/odeint/algebra/array_algebra.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta4.hpp>
#include <cmath>
#include <string_view>

#include "model/core/errors.h"
#include "model/flight/coupling.h"
#include "model/flight/flight_clock.h"
#include "model/flight/simulator.h"
#include "model/vehicle/motor.h"

namespace lipoid {
namespace {

namespace odeint = boost::numeric::odeint;

constexpr double kLongestStep_s = 0.0025;
constexpr double kShortestStep_s = 1e-5;
constexpr double kWindStep_s = 0.005;  // as in the simulator: the same gusts at any frame rate
constexpr double kTakenOff_m = 0.01;

// The longest step that follows the motors and their inductance, as in the simulator.
double LongestStep(const LiveSetup& setup) {
  const Vehicle driven = WithControllers(setup.vehicle);
  double longest_s = kLongestStep_s;
  const auto follow = [&](std::string_view what, double constant_s, std::string_view advice) {
    longest_s = std::min(longest_s, 1.4 * constant_s);
    if (longest_s >= kShortestStep_s) return;
    throw OptionError(fmt::format(
        "the {} of {} has a time constant of {:.3g} s, which needs steps below {:.3g} s. {}",
        what,
        setup.vehicle.name,
        constant_s,
        kShortestStep_s,
        advice));
  };
  if (driven.armature_inductance_H > 0.0) {
    follow(
        "armature current",
        driven.armature_inductance_H / driven.armature_resistance_Ohm,
        "Give the vehicle an armature_inductance_H of 0: its motors are then as fast as they are");
  }
  const double full_V = setup.cell.series * setup.cell.open_circuit_voltage(setup.initial_soc);
  follow("motors' speed",
         SpeedConstant_s(driven, HeldSpeed(driven, std::max(full_V, 0.0))),
         "Look at the units of its numbers");
  return longest_s;
}

template <std::size_t N>
class Live : public LivePlant {
 public:
  explicit Live(const LiveSetup& setup)
      : setup_(setup),
        plant_(setup.vehicle, {.drag = Blows(setup.wind)}),
        longest_step_s_(LongestStep(setup)) {
    Reset();
  }

  void Reset() override {
    x_.fill(0.0);
    x_[plant::kPosition + 2] = kGroundRest_m;
    inputs_ = {};
    battery_.emplace(setup_.cell, setup_.initial_soc);
    if (Blows(setup_.wind)) wind_.emplace(setup_.wind, setup_.seed, kWindStep_s);
    wind_due_s_ = 0.0;
    time_s_ = 0.0;
    below_cutoff_s_ = 0.0;
    report_ = {};
    report_.minimum_voltage_V = std::numeric_limits<double>::infinity();
    inputs_.supply = battery_->Linearize();
    Observe();
  }

  void Advance(const PerMotor<double>& duty, double dt_s) override {
    Require(dt_s > 0.0, "dt_s > 0", {{"dt_s", dt_s}});
    if (report_.over) return;
    for (std::size_t i = 0; i < 4; ++i) {
      Require(duty[i] >= 0.0 && duty[i] <= 1.0, "duty cycles in [0, 1]", {{"duty", duty[i]}});
      inputs_.duty[i] = report_.empty_s ? 0.0 : duty[i];
    }
    if (battery_->bends()) FollowTheCurrent(plant_, x_, inputs_, *battery_);
    const auto steps = std::max(1.0, std::ceil(dt_s / longest_step_s_ - kRounding_s));
    const double step_s = dt_s / steps;
    for (double k = 0.0; k < steps; ++k) {
      Blow();
      Step(step_s);
      wind_due_s_ -= step_s;
    }
    time_s_ += dt_s;
    inputs_.supply = battery_->Linearize();
    Observe();
    Judge(dt_s);
  }

  [[nodiscard]] const LiveState& state() const override { return state_; }
  [[nodiscard]] const LiveReport& report() const override { return report_; }

 private:
  using State = PlantState<double, N>;

  void Blow() {
    if (!wind_ || wind_due_s_ > kRounding_s) return;
    inputs_.wind_m_per_s = WindOn(x_, *wind_);
    wind_due_s_ += kWindStep_s;
  }

  void Step(double dt_s) {
    inputs_.supply = battery_->Linearize();
    const double before_C = x_[plant::kCharge];
    rk4_.do_step([this](const State& x, State& dx, double) { plant_.Derivative(x, inputs_, dx); },
                 x_,
                 0.0,
                 dt_s);
    battery_->Advance(x_[plant::kCharge] - before_C, dt_s);
  }

  void Observe() {
    const auto electrical = plant_.ElectricalAt(x_, inputs_);
    state_.time_s = time_s_;
    state_.position_m = TripleAt(x_, plant::kPosition);
    state_.position_m[2] -= kGroundRest_m;
    state_.velocity_m_per_s = TripleAt(x_, plant::kVelocity);
    state_.angles_rad = TripleAt(x_, plant::kAngles);
    state_.body_rates_rad_per_s = TripleAt(x_, plant::kRates);
    state_.specific_force_m_per_s2 = SpecificForce(plant_, x_, inputs_);
    state_.wind_m_per_s = inputs_.wind_m_per_s;
    state_.speed_rad_per_s = electrical.speed_rad_per_s;
    state_.battery_V = electrical.battery_V;
    state_.battery_A = electrical.battery_A;
    state_.soc = battery_->soc();
    report_.charge_C = x_[plant::kCharge];
    report_.minimum_voltage_V = std::min(report_.minimum_voltage_V, electrical.battery_V);
  }

  void Judge(double dt_s) {
    for (const double value : x_) {
      if (std::isfinite(value)) continue;
      report_.over = fmt::format("the state is not finite at {:.3f} s", time_s_);
      return;
    }
    const double pitch = x_[plant::kAngles + 1];
    if (!(std::abs(pitch) < kGimbalLock_rad)) {
      report_.over = fmt::format(
          "it stood on its nose or tail at {:.3f} s: at a pitch of 90 degrees Euler angles end "
          "(gimbal lock)",
          time_s_);
      return;
    }
    if (!report_.takeoff_s && -state_.position_m[2] > kTakenOff_m) report_.takeoff_s = time_s_;
    below_cutoff_s_ = state_.battery_V < battery_->cutoff_V() ? below_cutoff_s_ + dt_s : 0.0;
    if (!report_.cutoff_s && EmptyAfter(below_cutoff_s_)) {
      report_.cutoff_s = time_s_;
    }
    if (!report_.empty_s && state_.soc <= 0.0) report_.empty_s = time_s_;
  }

  LiveSetup setup_;
  Plant plant_;
  double longest_step_s_;
  std::optional<BatterySupply> battery_;
  std::optional<Wind> wind_;
  odeint::runge_kutta4<State, double, State, double, odeint::array_algebra> rk4_;
  State x_{};
  PlantInputs<double> inputs_;
  double time_s_ = 0.0;
  double wind_due_s_ = 0.0;
  double below_cutoff_s_ = 0.0;
  LiveState state_;
  LiveReport report_;
};

}  // namespace

std::unique_ptr<LivePlant> MakeLivePlant(const LiveSetup& setup) {
  CheckStart(setup.initial_soc);
  if (Blows(setup.wind)) RequireDrag(setup.vehicle);
  RequireQuadX(setup.vehicle, "an autopilot's interface");
  if (setup.vehicle.armature_inductance_H > 0.0) {
    return std::make_unique<Live<plant::kStatesWithInductance>>(setup);
  }
  return std::make_unique<Live<plant::kStates>>(setup);
}

}  // namespace lipoid
