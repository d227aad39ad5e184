#pragma once

/// @file
/// A vehicle on its battery that is flown from outside, step by step: it stands on the ground until
/// its thrust exceeds its weight, and goes on whatever happens to it.
///
///   auto plant = MakeLivePlant({.vehicle = LoadVehicle("mambo-coupled"),
///                               .cell = LoadCell("gifi-600mAh-1")});
///   plant->Advance({0.6, 0.6, 0.6, 0.6}, 0.0025);
///   plant->state().battery_V;
///
/// An empty battery (state of charge 0) gives nothing any more: the motors run out. A flight is
/// over only where its numbers are: at a pitch of 90 degrees, where Euler angles end (so there are
/// no flips), or where they are not finite. Tests: tests/model/flight/live_plant_test.cc.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "model/battery/cell.h"
#include "model/vehicle/allocation.h"
#include "model/vehicle/wind.h"

namespace lipoid {

struct LiveSetup {
  Vehicle vehicle;
  Cell cell;
  double initial_soc = 1.0;
  WindOptions wind = {};
  std::uint64_t seed = 0;  ///< of gusts
};

struct LiveState {
  double time_s = 0.0;
  Triple<double> position_m{};               ///< inertial, z down, from where it stood
  Triple<double> velocity_m_per_s{};         ///< inertial
  Triple<double> angles_rad{};               ///< roll, pitch, yaw
  Triple<double> body_rates_rad_per_s{};     ///< body
  Triple<double> specific_force_m_per_s2{};  ///< body; (0, 0, -g) at rest and level
  Triple<double> wind_m_per_s{};             ///< inertial, what the air moves
  PerMotor<double> speed_rad_per_s{};
  double battery_V = 0.0;  ///< of the pack, as battery_A
  double battery_A = 0.0;
  double soc = 1.0;
};

/// Since the last Reset().
struct LiveReport {
  double charge_C = 0.0;
  double minimum_voltage_V = 0.0;
  std::optional<double> cutoff_s;   ///< when the voltage had been below cut-off for a second
  std::optional<double> empty_s;    ///< when the state of charge reached 0
  std::optional<double> takeoff_s;  ///< when it first was a centimetre above the ground
  std::optional<std::string> over;  ///< why there are no further numbers, for people
};

class LivePlant {
 public:
  virtual ~LivePlant() = default;

  /// On the ground at rest, heading along X, motors still, the battery relaxed.
  virtual void Reset() = 0;
  /// Duty cycles in [0, 1], held for dt_s > 0. Nothing happens once the flight is over.
  virtual void Advance(const PerMotor<double>& duty, double dt_s) = 0;
  [[nodiscard]] virtual const LiveState& state() const = 0;
  [[nodiscard]] virtual const LiveReport& report() const = 0;
};

/// OptionError where the setup cannot be flown: a vehicle that is no quad-x, an empty cell, wind on a
/// vehicle without drag, motors faster than any step.
[[nodiscard]] std::unique_ptr<LivePlant> MakeLivePlant(const LiveSetup& setup);

}  // namespace lipoid
