#pragma once

/// @file
/// The whole vehicle as one state vector and one derivative: rigid body (3.4)-(3.7), four motors
/// (3.9)-(3.10) and the loop with the battery (3.11). The cell itself is not in the state: its fast
/// branches are stiff, and it takes its exact step between integrator steps (battery_supply.h).
///
///   X Y Z | Phi Theta Psi | U V W (inertial) | p q r (body) | omega_1..4 | charge | i_1..4
///
/// The currents are states only with l_a > 0. With motors at their equilibrium the speeds follow
/// the duty cycles at once and are no states (their slots rest). T is double, or an
/// automatic-differentiation scalar. Tests: tests/model/vehicle/plant_test.cc.

#include <array>
#include <cstddef>

#include "model/vehicle/ground.h"
#include "model/vehicle/powertrain.h"

namespace lipoid {

namespace plant {
inline constexpr std::size_t kPosition = 0;
inline constexpr std::size_t kAngles = 3;
inline constexpr std::size_t kVelocity = 6;
inline constexpr std::size_t kRates = 9;
inline constexpr std::size_t kSpeeds = 12;
inline constexpr std::size_t kCharge = 16;    ///< delivered since the start, in C
inline constexpr std::size_t kCurrents = 17;  ///< only with l_a > 0
inline constexpr std::size_t kStates = 17;
inline constexpr std::size_t kStatesWithInductance = 21;
}  // namespace plant

template <class T, std::size_t N = plant::kStates>
using PlantState = std::array<T, N>;

/// Three neighbouring states: the position, the angles, ...
template <class T, std::size_t N>
Triple<T> TripleAt(const PlantState<T, N>& x, std::size_t first) {
  return {x[first], x[first + 1], x[first + 2]};
}
template <class T, std::size_t N>
PerMotor<T> FourAt(const PlantState<T, N>& x, std::size_t first) {
  return {x[first], x[first + 1], x[first + 2], x[first + 3]};
}

/// What is held over an integrator step.
template <class T>
struct PlantInputs {
  PerMotor<T> duty{};
  Supply<T> supply{};
  Triple<double> wind_m_per_s{};  ///< inertial axes
};

/// Speeds, currents and the battery's side of the loop at one instant.
template <class T>
struct Electrical {
  PerMotor<T> speed_rad_per_s;
  PerMotor<T> current_A;
  T battery_V;
  T battery_A;
};

struct PlantOptions {
  bool motor_lag = true;  ///< off: speeds are (5.10) at once, an ideal source only
  bool drag = false;      ///< linear drag against the air
  bool ground = true;
};

class Plant {
 public:
  Plant(Vehicle vehicle, PlantOptions options)
      : v_(std::move(vehicle)),
        options_(options),
        per_mass_(1.0 / v_.mass_kg),
        per_inertia_{
            1.0 / v_.inertia_kg_m2[0], 1.0 / v_.inertia_kg_m2[1], 1.0 / v_.inertia_kg_m2[2]} {}

  [[nodiscard]] const Vehicle& vehicle() const { return v_; }
  [[nodiscard]] const PlantOptions& options() const { return options_; }

  template <class T, std::size_t N>
  [[nodiscard]] Electrical<T> ElectricalAt(const PlantState<T, N>& x,
                                           const PlantInputs<T>& in) const {
    Electrical<T> e;
    if (!options_.motor_lag) {
      e.battery_V = in.supply.voltage_V;
      for (std::size_t i = 0; i < 4; ++i) {
        e.speed_rad_per_s[i] = HeldSpeed(v_, T(in.duty[i] * e.battery_V));  // (5.10)
        e.current_A[i] = HoldingCurrent(v_, e.speed_rad_per_s[i]);          // (5.59)
      }
      e.battery_A = BatteryCurrent(in.duty, e.current_A);
      return e;
    }
    e.speed_rad_per_s = FourAt(x, plant::kSpeeds);
    if constexpr (N > plant::kCurrents) {
      e.current_A = FourAt(x, plant::kCurrents);
      e.battery_A = BatteryCurrent(in.duty, e.current_A);
      e.battery_V = in.supply.voltage_V - in.supply.resistance_Ohm * e.battery_A;
    } else {
      e.battery_V = LoopVoltage(v_, in.supply, in.duty, e.speed_rad_per_s);
      for (std::size_t i = 0; i < 4; ++i) {
        e.current_A[i] =
            ArmatureCurrent(v_, T(in.duty[i] * e.battery_V), e.speed_rad_per_s[i]);  // (3.9)
      }
      e.battery_A = BatteryCurrent(in.duty, e.current_A);  // (3.11)
    }
    return e;
  }

  template <class T, std::size_t N>
  void Derivative(const PlantState<T, N>& x, const PlantInputs<T>& in, PlantState<T, N>& dx) const {
    static_assert(N == plant::kStates || N == plant::kStatesWithInductance);
    const Attitude<T> attitude(TripleAt(x, plant::kAngles));
    const Triple<T> velocity = TripleAt(x, plant::kVelocity);
    const Triple<T> rates = TripleAt(x, plant::kRates);
    const Electrical<T> e = ElectricalAt(x, in);

    PerMotor<T> squares;
    for (std::size_t i = 0; i < 4; ++i) {
      squares[i] = e.speed_rad_per_s[i] * e.speed_rad_per_s[i];
    }
    Wrench<T> wrench = WrenchOf(v_, squares);  // (3.12)

    const Triple<T> down = attitude.Down();
    const T push = wrench.thrust_N * per_mass_;
    Triple<T> acceleration{
        -(push * down[0]), -(push * down[1]), T(kGravity_m_per_s2) - push * down[2]};  // (3.5)
    if (options_.drag) {
      for (std::size_t k = 0; k < 3; ++k) {
        acceleration[k] = acceleration[k] - (v_.linear_drag_N_s_per_m * per_mass_) *
                                                (velocity[k] - T(in.wind_m_per_s[k]));
      }
    }
    if (options_.ground && NearGround(v_, x[plant::kPosition + 2])) {
      const auto reaction =
          GroundContact(v_, TripleAt(x, plant::kPosition), attitude, velocity, rates);
      for (std::size_t k = 0; k < 3; ++k) {
        acceleration[k] = acceleration[k] + reaction.force_N[k] * per_mass_;
        wrench.torque_N_m[k] = wrench.torque_N_m[k] + reaction.torque_N_m[k];
      }
    }

    const Triple<T> angle_rates = attitude.AngleRates(rates);  // (3.6)
    const Triple<T> gyroscopic = GyroscopicTorque(v_.inertia_kg_m2, rates);
    for (std::size_t k = 0; k < 3; ++k) {
      dx[plant::kPosition + k] = velocity[k];  // (3.4)
      dx[plant::kAngles + k] = angle_rates[k];
      dx[plant::kVelocity + k] = acceleration[k];
      dx[plant::kRates + k] = (wrench.torque_N_m[k] - gyroscopic[k]) * per_inertia_[k];  // (3.7)
    }
    for (std::size_t i = 0; i < 4; ++i) {
      dx[plant::kSpeeds + i] =
          options_.motor_lag
              ? RotorAcceleration(v_, e.current_A[i], e.speed_rad_per_s[i])  // (3.10)
              : T(0.0);
    }
    dx[plant::kCharge] = e.battery_A;
    if constexpr (N > plant::kCurrents) {
      for (std::size_t i = 0; i < 4; ++i) {
        dx[plant::kCurrents + i] =
            (in.duty[i] * e.battery_V - v_.armature_resistance_Ohm * e.current_A[i] -
             v_.motor_constant_N_m_per_A * e.speed_rad_per_s[i]) *
            (1.0 / v_.armature_inductance_H);  // (3.9)
      }
    }
  }

 private:
  Vehicle v_;
  PlantOptions options_;
  double per_mass_;
  std::array<double, 3> per_inertia_;
};

}  // namespace lipoid
