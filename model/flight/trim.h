#pragma once

/// @file
/// Hover as an equilibrium: the speed that carries the weight, the voltage and current that hold
/// it, and what the battery gives for it. Tests: tests/model/flight/trim_test.cc.

#include "model/vehicle/battery_supply.h"

namespace lipoid {

struct Trim {
  double speed_rad_per_s = 0.0;  ///< omega_h = sqrt(m g/(4 k_T)) of a quadrotor
  double motor_V = 0.0;          ///< across the winding: D v_b without losses
  double motor_A = 0.0;
  double battery_V = 0.0;
  double battery_A = 0.0;
  double duty = 0.0;                       ///< more than 1: the voltage does not suffice
  double commanded_speed_rad_per_s = 0.0;  ///< omega_C0 that gives this duty
  bool power_suffices = true;  ///< false: no voltage of this supply gives the power; the rest is at
                               ///< the point of largest power

  [[nodiscard]] bool possible() const { return power_suffices && duty <= 1.0; }
};

/// Trim on a voltage behind a resistance. With compensation commands use v_b (5.52), else v_b0
/// (3.17).
[[nodiscard]] Trim HoverTrim(const Vehicle& vehicle,
                             const Supply<double>& supply,
                             bool compensate = false);

/// The voltage over the nominal one at which a hover takes D = 1, on a source without resistance:
/// below it the vehicle cannot hover.
[[nodiscard]] double LowestHoverXi(const Vehicle& vehicle);

/// The same on a battery; leaves it expecting the current found.
[[nodiscard]] Trim HoverTrim(const Vehicle& vehicle,
                             BatterySupply& battery,
                             bool compensate = false);

}  // namespace lipoid
