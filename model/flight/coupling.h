#pragma once

/// @file
/// How a plant and its battery move on together, for whatever flies them: the simulator under its
/// controller, an autopilot from outside.
/// Tests: tests/model/flight/simulator_test.cc, tests/model/flight/live_plant_test.cc.

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string_view>

#include "model/core/errors.h"
#include "model/core/options.h"
#include "model/vehicle/battery_supply.h"
#include "model/vehicle/plant.h"
#include "model/vehicle/wind.h"

namespace lipoid {

/// New duty cycles make the current jump: the battery's straight line is moved to where it lands.
template <std::size_t R, std::size_t N>
void FollowTheCurrent(const RotorPlant<R>& plant,
                      const PlantState<double, N>& x,
                      PlantInputs<double, R>& inputs,
                      BatterySupply& battery) {
  constexpr double kNear_A = 1e-6;  // of a tangent: nothing
  double last_A = std::numeric_limits<double>::quiet_NaN();
  for (int round = 0; round < 8; ++round) {
    inputs.supply = battery.Linearize();
    const double now_A = plant.ElectricalAt(x, inputs).battery_A;
    if (std::abs(now_A - last_A) < kNear_A) return;
    battery.Expect(now_A);
    last_A = now_A;
  }
}

/// What an accelerometer feels: the specific force, in body axes.
template <std::size_t R, std::size_t N>
[[nodiscard]] Triple<double> SpecificForce(const RotorPlant<R>& plant,
                                           const PlantState<double, N>& x,
                                           const PlantInputs<double, R>& inputs) {
  PlantState<double, N> rate;
  plant.Derivative(x, inputs, rate);
  Triple<double> force = TripleAt(rate, plant::kVelocity);
  force[2] -= kGravity_m_per_s2;
  return Attitude<double>(TripleAt(x, plant::kAngles)).ToBody(force);
}

/// The wind during its next step, where and how fast the vehicle is.
template <std::size_t N>
[[nodiscard]] Triple<double> WindOn(const PlantState<double, N>& x, Wind& wind) {
  double square = 0.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const double relative = x[plant::kVelocity + k] - wind.mean_m_per_s()[k];
    square += relative * relative;
  }
  return wind.Step(-x[plant::kPosition + 2], std::sqrt(square));
}

[[nodiscard]] inline bool Blows(const WindOptions& wind) {
  return wind.wind_x_m_per_s != 0.0 || wind.wind_y_m_per_s != 0.0 || wind.wind_z_m_per_s != 0.0 ||
         wind.gusts_m_per_s > 0.0;
}

/// OptionError where the air cannot act on the vehicle.
inline void RequireDrag(const Vehicle& vehicle) {
  if (vehicle.linear_drag_N_s_per_m > 0.0) return;
  throw OptionError(fmt::format(
      "drag and wind need a vehicle with linear_drag_N_s_per_m; {} has none. Write it into a "
      "vehicle file and give that",
      vehicle.name));
}

/// OptionError where the vehicle is no quadrotor on an X; `what` is what flies nothing else.
inline void RequireQuadX(const Vehicle& vehicle, std::string_view what) {
  if (vehicle.layout == RotorLayout::kQuadX) return;
  throw OptionError(fmt::format(
      "{} flies vehicles of the layout quad-x; {} has the layout {}. Give another vehicle",
      what,
      vehicle.name,
      options_internal::ToText(vehicle.layout)));
}

}  // namespace lipoid
