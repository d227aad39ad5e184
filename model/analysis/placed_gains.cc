#include "model/analysis/placed_gains.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "model/analysis/poles.h"
#include "model/control/flight_controller.h"
#include "model/control/riccati.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kAttitudeOfLag = 0.2;  // w tau
constexpr double kYawOfAttitude = 0.5;
constexpr double kAltitudeOfAttitude = 0.5;
constexpr double kPositionOfAttitude = 0.25;
constexpr double kFastestPosition_rad_per_s = 3.0;
constexpr double kReferenceOfPosition = 0.4;
constexpr double kFastestClimb_rad_per_s = 2.5;
constexpr double kSpeed_m_per_s = 3.0;
constexpr double kError_rad = 0.1;  // that may ask for the share of torque of the references

// The highest w at which K_e times the error stays below an acceleration: K_e is w² (3 - 8 w tau).
double Within(double wanted_rad_per_s, double lag_s, double acceleration_rad_per_s2) {
  double low = 0.0;
  double high = wanted_rad_per_s;
  const auto asked = [&](double omega) {
    return kError_rad * ThreePolesAt(omega, lag_s).proportional;
  };
  if (asked(high) <= acceleration_rad_per_s2) return high;
  for (int k = 0; k < 60; ++k) {
    const double middle = 0.5 * (low + high);
    (asked(middle) <= acceleration_rad_per_s2 ? low : high) = middle;
  }
  return low;
}

}  // namespace

bool IsOfTheThesis(const Vehicle& vehicle) { return vehicle.name.rfind("mambo", 0) == 0; }

ErrorGains ThreePolesAt(double omega_rad_per_s, double lag_s) {
  const double w = omega_rad_per_s;
  const double q = 1.0 - 3.0 * w * lag_s;
  Require(w > 0.0 && q > 0.0, "0 < w < 1/(3 tau)", {{"w", w}, {"tau", lag_s}});
  return {.proportional = w * w * (w * lag_s + 3.0 * q),
          .integral = w * w * w * q,
          .derivative = 3.0 * w * (w * lag_s + q)};
}

PlacedGains PlaceGains(const Vehicle& vehicle) {
  const HoverResponse response = ResponseAtHover(vehicle, HoverAt(vehicle, 1.0));
  const double lag_s = response.pitch.lag_s + 0.5 * kControlStep_s;
  const Triple<double> limits =
      AngleReferenceLimits(vehicle, HeldSpeed(vehicle, vehicle.nominal_voltage_V));
  PlacedGains placed;
  placed.lag_s = lag_s;
  placed.attitude_rad_per_s = Within(kAttitudeOfLag / lag_s, lag_s, std::min(limits[0], limits[1]));
  placed.yaw_rad_per_s = Within(kYawOfAttitude * placed.attitude_rad_per_s, lag_s, limits[2]);
  placed.altitude_rad_per_s = kAltitudeOfAttitude * placed.attitude_rad_per_s;
  placed.position_rad_per_s =
      std::min(kFastestPosition_rad_per_s, kPositionOfAttitude * placed.attitude_rad_per_s);
  Gains& gains = placed.gains;
  gains.name = kPlacedGains;
  gains.altitude = ThreePolesAt(placed.altitude_rad_per_s, lag_s);
  gains.attitude = ThreePolesAt(placed.attitude_rad_per_s, lag_s);
  gains.yaw = ThreePolesAt(placed.yaw_rad_per_s, lag_s);
  const double p = placed.position_rad_per_s;
  // Both poles of X'' = -g (K_p X + K_d X').
  gains.position.proportional_rad_per_m = p * p / kGravity_m_per_s2;
  gains.position.derivative_rad_s_per_m = 2.0 * p / kGravity_m_per_s2;
  References& references = gains.references;
  references.altitude_rad_per_s = std::min(kFastestClimb_rad_per_s, placed.altitude_rad_per_s);
  references.attitude_rad_per_s = std::min(references.attitude_rad_per_s, 1.0 / lag_s);
  references.yaw_rad_per_s = placed.yaw_rad_per_s;
  references.position_rad_per_s = kReferenceOfPosition * p;
  // A critically damped reference that is told to go far begins with 2 omega times its speed.
  const double weight_N = vehicle.mass_kg * kGravity_m_per_s2;
  const double highest = HeldSpeed(vehicle, vehicle.nominal_voltage_V);
  const double most_N = vehicle.total_thrust_coefficient_N_s2() * highest * highest;
  const double spare = std::clamp(most_N / weight_N - 1.0, 0.1, 1.0);
  const double reach = 0.25 * kGravity_m_per_s2 / references.altitude_rad_per_s;
  references.climb_m_per_s = std::min(references.climb_m_per_s, reach * spare);
  references.descent_m_per_s = std::min(references.descent_m_per_s, reach);
  references.speed_m_per_s = kSpeed_m_per_s;
  return placed;
}

PlacedGains PlaceRegulators(const Vehicle& vehicle) {
  PlacedGains placed = PlaceGains(vehicle);
  const auto regulator = [](double omega) {
    return AxisRegulator(
               {.error_per_s2 = 0.0, .integral_per_s3 = omega * omega * omega, .rate_per_s = 0.0})
        .gains;
  };
  placed.gains.altitude = regulator(placed.altitude_rad_per_s);
  placed.gains.attitude = regulator(placed.attitude_rad_per_s);
  placed.gains.yaw = regulator(placed.yaw_rad_per_s);
  return placed;
}

std::string PlacedGains::Brief() const {
  return fmt::format(
      "gains placed from the motors' lag of {:.3g} ms: poles of the attitude at {:.3g} rad/s, yaw "
      "{:.3g}, altitude {:.3g}, position {:.3g}",
      1e3 * lag_s,
      attitude_rad_per_s,
      yaw_rad_per_s,
      altitude_rad_per_s,
      position_rad_per_s);
}

Gains GainsFor(const std::string& name,
               const Vehicle& vehicle,
               const std::string& thesis_default,
               std::string_view law) {
  const bool regulator = law == "lqr";
  if (name.empty() && !regulator && IsOfTheThesis(vehicle)) return LoadGains(thesis_default);
  if (!name.empty() && name != kPlacedGains) return LoadGains(name);
  return (regulator ? PlaceRegulators(vehicle) : PlaceGains(vehicle)).gains;
}

}  // namespace lipoid
