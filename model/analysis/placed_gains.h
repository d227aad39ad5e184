#pragma once

/// @file
/// Gains for a vehicle of which none are known: poles placed by how fast its own motors follow and
/// by what torque they have.
///
/// With tau the motors' lag about hover at nominal voltage and half a control step, an axis is
/// y'' = nu/(tau s + 1). Three of its poles go to -w and the fourth is then at -(1/tau - 3 w):
///
///   K_edot = 3 w (w tau + q),   K_e = w² (w tau + 3 q),   K_eI = w³ q,   q = 1 - 3 w tau
///
/// The attitude has w = 1/(5 tau), which leaves the loop's gain a factor of more than two up and down
/// as the battery's voltage falls. Yaw and altitude have half of that, the two poles of the position
/// a quarter and at most 3 rad/s. Roll, pitch and yaw are slower where an error of 0.1 rad would ask
/// for more than the share of the motors' torque that references may ask for
/// (AngleReferenceLimits()), so that inertia and propellers count. References are as fast as the
/// poles of altitude (at most 2.5 rad/s) and yaw, at most 1/tau for the attitude, and 0.4 of the poles
/// of the position. Climb and descent are so fast that they begin with half of the acceleration
/// which the thrust can give, or half of g; 2 m/s and 1.5 m/s at most.
/// Tests: tests/model/analysis/placed_gains_test.cc.

#include <string>
#include <string_view>

#include "model/control/gains.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

/// The name of such gains.
inline constexpr std::string_view kPlacedGains = "placed";
/// What a message says of them where others do not keep the vehicle stable.
inline constexpr std::string_view kPlacedGainsHint =
    "--gains placed computes gains from the lag of this vehicle's motors";

struct PlacedGains {
  Gains gains;
  double lag_s;  ///< tau
  double attitude_rad_per_s;
  double yaw_rad_per_s;
  double altitude_rad_per_s;
  double position_rad_per_s;

  /// In one sentence, for people.
  [[nodiscard]] std::string Brief() const;
};

[[nodiscard]] PlacedGains PlaceGains(const Vehicle& vehicle);

/// The same for the control law `lqr`: regulators of the axes whose weight on the integral alone puts
/// their poles at these distances from zero (Butterworth's, by AxisRegulator()).
[[nodiscard]] PlacedGains PlaceRegulators(const Vehicle& vehicle);

/// Gains of an axis whose lag is tau: three poles at -w, for 0 < w < 1/(3 tau).
[[nodiscard]] ErrorGains ThreePolesAt(double omega_rad_per_s, double lag_s);

/// Whether it is one of the thesis' vehicles, whose names begin with "mambo".
[[nodiscard]] bool IsOfTheThesis(const Vehicle& vehicle);

/// The gains of this name for this vehicle: "placed", a shipped set, or a gains file; an empty name
/// is `thesis_default` for the thesis' vehicles, and "placed" for all others and for the control law
/// lqr.
[[nodiscard]] Gains GainsFor(const std::string& name,
                             const Vehicle& vehicle,
                             const std::string& thesis_default,
                             std::string_view law = "inversion");

}  // namespace lipoid
