#pragma once

/// @file
/// What steady level flight asks of the propulsion: rotor speed, motor voltage and current, and the
/// power of the battery. In hover from the vehicle's thrust and torque coefficients alone:
///
///   omega = sqrt(m g/k)                                     k: total thrust coefficient
///   u = ((k_e² + r_a b) omega + r_a k_N omega²)/k_e         (3.16)
///   i = (b omega + k_N omega²)/k_e                          (3.14)
///
/// At an airspeed V by momentum and blade-element theory, which want the propellers' diameter
/// (H. Glauert; J. G. Leishman, Principles of Helicopter Aerodynamics, 2nd ed., chapters 2, 3, 5):
///
///   D = d V + rho f V²/2,  T = sqrt((m g)² + D²),  tan alpha = D/(m g)
///   v_i = T/(2 rho A sqrt((V cos alpha)² + (V sin alpha + v_i)²))              induced velocity
///   T = c (theta (omega² R² + L V² cos² alpha) - (V sin alpha + v_i) omega R)  thrust, by omega
///   P = D V + kappa T v_i + p omega³ (1 + K mu²),  mu = V cos alpha/(omega R)  shaft power
///
/// A is the area of all disks. Of coaxial pairs, whose lower rotors have less thrust at the same speed and
/// torque, it is the smaller one at which the flow asks for as much power as through the disks of the same
/// rotors apart: what the file says that a pair loses is induced power, and the blades' drag is that of single
/// rotors. theta, the inflow at which a rotor has no thrust, is that of hover over `hover_inflow_share`; c
/// and p make both laws those of the vehicle file in hover. The file's coefficients are taken at 1.225 kg/m³.
///
/// Valid for level flight of fixed-pitch rotors up to mu = 0.35 (beyond, the retreating blade stalls),
/// with the rotors' wakes apart from each other. Tests: tests/model/vehicle/level_flight_test.cc.

#include <optional>

#include "model/core/options.h"
#include "model/vehicle/vehicle.h"

namespace lipoid {

inline constexpr double kSeaLevelDensity_kg_per_m3 = 1.225;  // of the standard atmosphere
inline constexpr double kLargestAdvanceRatio = 0.35;

struct LevelFlightOptions {
  double air_density_kg_per_m3 = kSeaLevelDensity_kg_per_m3;
  double flat_plate_area_m2 = 0.0;
  double induced_power_factor = 1.15;
  double profile_power_growth = 4.65;
  double hover_inflow_share = 0.45;

  friend bool operator==(const LevelFlightOptions&, const LevelFlightOptions&) = default;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("air_density_kg_per_m3",
      self.air_density_kg_per_m3,
      Range{0.1, 2.0},
      "density of the air in kg/m^3; thrust and torque of the rotors go with it");
    v("flat_plate_area_m2",
      self.flat_plate_area_m2,
      Range{0.0, 100.0},
      "drag area of the vehicle in m^2, drag coefficient times frontal area; 0: assumed from the "
      "mass as that of a body of 500 kg/m^3 with a drag coefficient of 1");
    v("induced_power_factor",
      self.induced_power_factor,
      Range{1.0, 2.0},
      "kappa, induced power over that of a uniform flow through the disk (Leishman: 1.15)");
    v("profile_power_growth",
      self.profile_power_growth,
      Range{0.0, 10.0},
      "K, by which the blades' own drag grows with the square of the advance ratio (Leishman: "
      "4.65); less 2, which is their drag in the plane of the disk, where the vehicle has a linear "
      "drag");
    v("hover_inflow_share",
      self.hover_inflow_share,
      Range{0.1, 0.9},
      "induced velocity in hover over the axial velocity at which the rotor has no thrust "
      "(0.45: a 10 x 4.7 propeller has no thrust at an advance ratio V/(n D) of about 0.6)");
  }
};

/// The working point of the motors, all alike.
struct LevelFlight {
  double airspeed_m_per_s = 0.0;
  double tilt_rad = 0.0;
  double thrust_N = 0.0;  ///< of all rotors together
  double speed_rad_per_s = 0.0;
  double motor_V = 0.0;     ///< across each winding
  double motor_A = 0.0;     ///< through each winding
  double battery_V = 0.0;   ///< the least that gives this: the duty cycle is 1
  double shaft_W = 0.0;     ///< that all propellers take
  double induced_W = 0.0;   ///< of it, with kappa; NaN where the propellers' diameter is not known
  double profile_W = 0.0;   ///< of it; likewise
  double parasite_W = 0.0;  ///< of it, against the drag of the vehicle
  double advance_ratio = 0.0;
  /// Of momentum theory in hover: the ideal power over the shaft power. NaN where the diameter is
  /// not known.
  double figure_of_merit = 0.0;
};

/// Hover in still air at sea level by the coefficients of the vehicle file alone: without what momentum
/// theory says of the propellers (induced_W, profile_W and figure_of_merit are NaN), and so without its
/// objections. The one place that computes the working point of hover.
[[nodiscard]] LevelFlight HoverByCoefficients(const Vehicle& vehicle);

/// Level flight at this airspeed >= 0: at 0, hover in still air. OptionError where momentum theory
/// rules the vehicle's propellers out, and where it has no propeller_diameter_m for an airspeed
/// above 0.
[[nodiscard]] LevelFlight Cruise(const Vehicle& vehicle,
                                 double airspeed_m_per_s,
                                 const LevelFlightOptions& options = {});

/// Mean voltage of the pulses, D v_b, that a battery of this voltage gives the motors: without diodes in the
/// speed controllers it does not depend on the battery.
[[nodiscard]] double PulseVoltage(const Vehicle& vehicle,
                                  const LevelFlight& flight,
                                  double battery_V);

/// Power of a battery of this voltage, with speed controllers and avionics. Nothing switches at a duty cycle
/// of 1 or, where the voltage does not suffice, more.
[[nodiscard]] double BatteryPower(const Vehicle& vehicle,
                                  const LevelFlight& flight,
                                  double battery_V);

/// The speeds at which a battery of this voltage lasts longest and carries farthest, among those at
/// which the duty cycle is at most 1 and the theory holds. None where the vehicle cannot hover on it.
struct BestSpeeds {
  LevelFlight endurance;
  LevelFlight range;
  double fastest_m_per_s = 0.0;  ///< at a duty cycle of 1, or where the theory ends
};
[[nodiscard]] std::optional<BestSpeeds> FindBestSpeeds(const Vehicle& vehicle,
                                                       double battery_V,
                                                       const LevelFlightOptions& options = {});

}  // namespace lipoid
