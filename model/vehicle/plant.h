#pragma once

/// @file
/// The whole vehicle as one state vector and one derivative: rigid body (3.4)-(3.7), R motors
/// (3.9)-(3.10) and the loop with the battery (3.11). The cell itself is not in the state: its fast
/// branches are stiff, and it takes its exact step between integrator steps (battery_supply.h).
///
///   X Y Z | Phi Theta Psi | U V W (inertial) | p q r (body) | omega_1..R | charge | i_1..R
///
/// The currents are states only with l_a > 0. With motors at their equilibrium the speeds follow
/// the duty cycles at once and are no states (their slots rest). T is double, or an
/// automatic-differentiation scalar. Tests: tests/model/vehicle/plant_test.cc.

#include <array>
#include <cstddef>
#include <type_traits>

#include "model/core/errors.h"
#include "model/vehicle/ground.h"
#include "model/vehicle/powertrain.h"

namespace lipoid {

namespace plant {
inline constexpr std::size_t kPosition = 0;
inline constexpr std::size_t kAngles = 3;
inline constexpr std::size_t kVelocity = 6;
inline constexpr std::size_t kRates = 9;
inline constexpr std::size_t kSpeeds = 12;
/// Delivered since the start, in C.
constexpr std::size_t Charge(std::size_t rotors) { return kSpeeds + rotors; }
/// Only with l_a > 0.
constexpr std::size_t Currents(std::size_t rotors) { return Charge(rotors) + 1; }
constexpr std::size_t States(std::size_t rotors) { return Currents(rotors); }
constexpr std::size_t StatesWithInductance(std::size_t rotors) { return States(rotors) + rotors; }

// Of a quadrotor.
inline constexpr std::size_t kCharge = Charge(4);
inline constexpr std::size_t kCurrents = Currents(4);
inline constexpr std::size_t kStates = States(4);
inline constexpr std::size_t kStatesWithInductance = StatesWithInductance(4);
}  // namespace plant

template <class T, std::size_t N = plant::kStates>
using PlantState = std::array<T, N>;

/// Three neighbouring states: the position, the angles, ...
template <class T, std::size_t N>
Triple<T> TripleAt(const PlantState<T, N>& x, std::size_t first) {
  return {x[first], x[first + 1], x[first + 2]};
}
template <std::size_t R, class T, std::size_t N>
PerMotor<T, R> MotorsAt(const PlantState<T, N>& x, std::size_t first) {
  PerMotor<T, R> values;
  for (std::size_t i = 0; i < R; ++i) values[i] = x[first + i];
  return values;
}

/// What is held over an integrator step.
template <class T, std::size_t R = 4>
struct PlantInputs {
  PerMotor<T, R> duty{};
  Supply<T> supply{};
  Triple<double> wind_m_per_s{};  ///< inertial axes
};

/// Speeds, currents and the battery's side of the loop at one instant.
template <class T, std::size_t R = 4>
struct Electrical {
  PerMotor<T, R> speed_rad_per_s;
  PerMotor<T, R> current_A;
  T battery_V;
  T battery_A;
};

struct PlantOptions {
  bool motor_lag = true;  ///< off: speeds are (5.10) at once, an ideal source only
  bool drag = false;      ///< linear drag against the air
  bool ground = true;
};

/// A vehicle of R rotors.
template <std::size_t R>
class RotorPlant {
 public:
  RotorPlant(Vehicle vehicle, PlantOptions options)
      : v_(std::move(vehicle)),
        driven_(WithControllers(v_)),
        options_(options),
        per_mass_(1.0 / v_.mass_kg),
        per_inertia_{
            1.0 / v_.inertia_kg_m2[0], 1.0 / v_.inertia_kg_m2[1], 1.0 / v_.inertia_kg_m2[2]} {
    Require(v_.rotor_count() == R,
            "a plant of as many rotors as the vehicle has",
            {{"rotors of the plant", double(R)}, {"of the vehicle", double(v_.rotor_count())}});
  }

  [[nodiscard]] const Vehicle& vehicle() const { return v_; }
  [[nodiscard]] const PlantOptions& options() const { return options_; }

  template <class T, std::size_t N>
  [[nodiscard]] Electrical<T, R> ElectricalAt(const PlantState<T, N>& x,
                                              const PlantInputs<T, R>& in) const {
    Electrical<T, R> e;
    if (!options_.motor_lag) {
      e.battery_V = in.supply.voltage_V;
      for (std::size_t i = 0; i < R; ++i) {
        e.speed_rad_per_s[i] =
            HeldSpeed(driven_, DriveVoltage(v_.esc, in.duty[i], e.battery_V));  // (5.10)
        e.current_A[i] = HoldingCurrent(v_, e.speed_rad_per_s[i]);              // (5.59)
      }
      e.battery_A = BatteryShare(in, e);
      return e;
    }
    e.speed_rad_per_s = MotorsAt<R>(x, plant::kSpeeds);
    if constexpr (N > kStates) {
      e.current_A = MotorsAt<R>(x, kCurrents);
      const T motors_A = ControllersCurrent(v_, in.duty, e.current_A);
      e.battery_V = VoltageUnderCurrent(v_, in.supply, motors_A);
    } else {
      e.battery_V = LoopVoltage(v_, in.supply, in.duty, e.speed_rad_per_s);
      for (std::size_t i = 0; i < R; ++i) {
        e.current_A[i] = MotorCurrent(v_, in.duty[i], e.battery_V, e.speed_rad_per_s[i]);  // (3.9)
      }
    }
    e.battery_A = BatteryShare(in, e);  // (3.11)
    return e;
  }

  template <class T, std::size_t N>
  void Derivative(const PlantState<T, N>& x,
                  const PlantInputs<T, R>& in,
                  PlantState<T, N>& dx) const {
    static_assert(N == kStates || N == plant::StatesWithInductance(R));
    const Attitude<T> attitude(TripleAt(x, plant::kAngles));
    const Triple<T> velocity = TripleAt(x, plant::kVelocity);
    const Triple<T> rates = TripleAt(x, plant::kRates);
    const Electrical<T, R> e = ElectricalAt(x, in);

    PerMotor<T, R> squares;
    for (std::size_t i = 0; i < R; ++i) {
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
    for (std::size_t i = 0; i < R; ++i) {
      dx[plant::kSpeeds + i] =
          options_.motor_lag
              ? RotorAcceleration(v_, e.current_A[i], e.speed_rad_per_s[i])  // (3.10)
              : T(0.0);
    }
    dx[kCharge] = e.battery_A;
    if constexpr (N > kStates) {
      for (std::size_t i = 0; i < R; ++i) {
        dx[kCurrents + i] = CurrentRate(in.duty[i], e, i);
      }
    }
  }

 private:
  static constexpr std::size_t kCharge = plant::Charge(R);
  static constexpr std::size_t kCurrents = plant::Currents(R);
  static constexpr std::size_t kStates = plant::States(R);

  // The current of motors and avionics.
  template <class T>
  [[nodiscard]] T BatteryShare(const PlantInputs<T, R>& in, const Electrical<T, R>& e) const {
    const T motors_A = ControllersCurrent(v_, in.duty, e.current_A);
    if (v_.avionics_power_W == 0.0) return motors_A;
    return motors_A + v_.avionics_power_W / e.battery_V;
  }

  // (3.9) with the controller; through diodes a current ends at 0.
  template <class T>
  [[nodiscard]] T CurrentRate(const T& duty, const Electrical<T, R>& e, std::size_t i) const {
    const T& current_A = e.current_A[i];
    const T rate =
        (DriveVoltage(v_.esc, duty, e.battery_V) - driven_.armature_resistance_Ohm * current_A -
         v_.motor_constant_N_m_per_A * e.speed_rad_per_s[i]) *
        (1.0 / v_.armature_inductance_H);  // (3.9)
    if (v_.esc.synchronous || ScalarPart(current_A) > 0.0 || ScalarPart(rate) > 0.0) return rate;
    return (-driven_.armature_resistance_Ohm / v_.armature_inductance_H) * current_A;
  }

  Vehicle v_;
  Vehicle driven_;
  PlantOptions options_;
  double per_mass_;
  std::array<double, 3> per_inertia_;
};

using Plant = RotorPlant<4>;

/// call(std::integral_constant<std::size_t, R>) for the number of rotors that the vehicle has.
template <class Call>
auto ForRotorsOf(const Vehicle& vehicle, Call&& call) {
  switch (vehicle.rotor_count()) {
    case 4:
      return call(std::integral_constant<std::size_t, 4>{});
    case 6:
      return call(std::integral_constant<std::size_t, 6>{});
    default:
      return call(std::integral_constant<std::size_t, kMostRotors>{});
  }
}

}  // namespace lipoid
