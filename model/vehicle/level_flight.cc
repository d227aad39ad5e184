#include "model/vehicle/level_flight.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kRootCut = 0.15;  // where a blade begins, over R
constexpr double kInPlaneGrowth = 2.0;
constexpr double kBodyDensity_kg_per_m3 = 500.0;

// The rotors of a vehicle together, as hover has them.
struct RotorWork {
  double count;
  double thrust_N_s2;  // over the square of the speed
  double torque_N_m_s2;
  double radius_m = 0.0;      // 0: not known
  double area_m2 = 0.0;       // A
  double inflow = 0.0;        // lambda in hover, v_i/(omega R)
  double profile_W_s3 = 0.0;  // p
};

RotorWork RotorsWithoutTheory(const Vehicle& vehicle, double density) {
  Require(vehicle.mass_kg > 0.0 && vehicle.thrust_coefficient_N_s2 > 0.0 &&
              vehicle.motor_constant_N_m_per_A > 0.0,
          "a vehicle with mass, propellers and motors",
          {{"mass_kg", vehicle.mass_kg}});
  return {.count = static_cast<double>(vehicle.rotor_count()),
          .thrust_N_s2 = density * vehicle.total_thrust_coefficient_N_s2(),
          .torque_N_m_s2 = density * vehicle.torque_coefficient_N_m_s2};
}

RotorWork RotorsIn(const Vehicle& vehicle, const LevelFlightOptions& options) {
  RotorWork rotors =
      RotorsWithoutTheory(vehicle, options.air_density_kg_per_m3 / kSeaLevelDensity_kg_per_m3);
  if (vehicle.propeller_diameter_m <= 0.0) return rotors;
  rotors.radius_m = 0.5 * vehicle.propeller_diameter_m;
  const double thrusts = vehicle.SumsOverRotors().thrust;  // of a single rotor
  const double disks = thrusts * thrusts * thrusts / (rotors.count * rotors.count);
  rotors.area_m2 = disks * std::numbers::pi * rotors.radius_m * rotors.radius_m;
  rotors.inflow =
      std::sqrt(rotors.thrust_N_s2 / (2.0 * options.air_density_kg_per_m3 * rotors.area_m2)) /
      rotors.radius_m;
  const double ideal_W_s3 = rotors.thrust_N_s2 * rotors.inflow * rotors.radius_m;
  const double shaft_W_s3 = rotors.count * rotors.torque_N_m_s2;
  rotors.profile_W_s3 = shaft_W_s3 - options.induced_power_factor * ideal_W_s3;
  if (rotors.profile_W_s3 < 0.0) {
    throw OptionError(fmt::format(
        "the propellers of {} would have a figure of merit of {:.3f} in hover: momentum theory "
        "allows less than {:.3f} with an induced power factor of {:g}. Thrust coefficient, torque "
        "coefficient and propeller diameter do not belong together",
        vehicle.name,
        ideal_W_s3 / shaft_W_s3,
        1.0 / options.induced_power_factor,
        options.induced_power_factor));
  }
  return rotors;
}

// v_i of a thrust T over 2 rho A (in m²/s²), against a flow along and across the disk.
double InducedVelocity(double thrust_m2_per_s2, double across_m_per_s, double along_m_per_s) {
  const double still = std::sqrt(thrust_m2_per_s2);
  if (across_m_per_s == 0.0 && along_m_per_s == 0.0) return still;
  // Rises with v_i from below 0; both flows take v_i below that of hover.
  const auto surplus = [&](double v) {
    return v * std::hypot(along_m_per_s, across_m_per_s + v) - thrust_m2_per_s2;
  };
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      surplus, 0.0, still, boost::math::tools::eps_tolerance<double>(), iterations);
  return 0.5 * (bracket.first + bracket.second);
}

void SetMotors(const Vehicle& vehicle, const RotorWork& rotors, LevelFlight& flight) {
  const double omega = flight.speed_rad_per_s;
  const double torque_N_m = flight.shaft_W / (rotors.count * omega);
  flight.motor_A =
      (vehicle.friction_N_m_s * omega + torque_N_m) / vehicle.motor_constant_N_m_per_A;  // (3.14)
  flight.motor_V = vehicle.armature_resistance_Ohm * flight.motor_A +
                   vehicle.motor_constant_N_m_per_A * omega;  // (3.16)
  flight.battery_V = flight.motor_V + vehicle.esc.resistance_Ohm * flight.motor_A;
}

LevelFlight HoverOf(const Vehicle& vehicle, const RotorWork& rotors) {
  LevelFlight flight;
  flight.figure_of_merit = flight.induced_W = flight.profile_W =
      std::numeric_limits<double>::quiet_NaN();
  flight.thrust_N = vehicle.mass_kg * kGravity_m_per_s2;
  flight.speed_rad_per_s = std::sqrt(flight.thrust_N / rotors.thrust_N_s2);  // (3.12)
  flight.shaft_W = rotors.count * rotors.torque_N_m_s2 * std::pow(flight.speed_rad_per_s, 3);
  SetMotors(vehicle, rotors, flight);
  if (rotors.radius_m <= 0.0) return flight;
  flight.figure_of_merit =
      rotors.thrust_N_s2 * rotors.inflow * rotors.radius_m / (rotors.count * rotors.torque_N_m_s2);
  flight.profile_W = rotors.profile_W_s3 * std::pow(flight.speed_rad_per_s, 3);
  flight.induced_W = flight.shaft_W - flight.profile_W;
  return flight;
}

}  // namespace

LevelFlight HoverByCoefficients(const Vehicle& vehicle) {
  return HoverOf(vehicle, RotorsWithoutTheory(vehicle, 1.0));
}

LevelFlight Cruise(const Vehicle& vehicle,
                   double airspeed_m_per_s,
                   const LevelFlightOptions& options) {
  Require(airspeed_m_per_s >= 0.0, "an airspeed of at least 0", {{"m/s", airspeed_m_per_s}});
  const RotorWork rotors = RotorsIn(vehicle, options);
  if (airspeed_m_per_s == 0.0) return HoverOf(vehicle, rotors);
  if (rotors.radius_m <= 0.0) {
    throw OptionError(
        fmt::format("{} does not say its propeller_diameter_m, which the power of forward flight "
                    "depends on: write it into a vehicle file and give that",
                    vehicle.name));
  }
  LevelFlight flight = HoverOf(vehicle, rotors);
  const double weight_N = flight.thrust_N;
  flight.airspeed_m_per_s = airspeed_m_per_s;
  const double rho = options.air_density_kg_per_m3;
  const double plate_m2 = options.flat_plate_area_m2 > 0.0
                              ? options.flat_plate_area_m2
                              : std::pow(vehicle.mass_kg / kBodyDensity_kg_per_m3, 2.0 / 3.0);
  const double drag_N = vehicle.linear_drag_N_s_per_m * airspeed_m_per_s +
                        0.5 * rho * plate_m2 * airspeed_m_per_s * airspeed_m_per_s;
  flight.thrust_N = std::hypot(weight_N, drag_N);
  flight.tilt_rad = std::atan2(drag_N, weight_N);
  const double across = airspeed_m_per_s * std::sin(flight.tilt_rad);
  const double along = airspeed_m_per_s * std::cos(flight.tilt_rad);
  const double induced =
      InducedVelocity(flight.thrust_N / (2.0 * rho * rotors.area_m2), across, along);
  // a (omega R)² - b omega R = c, whose larger root is the speed.
  const double theta = rotors.inflow / options.hover_inflow_share;
  const double per_m2 =
      rotors.thrust_N_s2 / (rotors.radius_m * rotors.radius_m * (theta - rotors.inflow));
  const double b = across + induced;
  const double c = flight.thrust_N / per_m2 - theta * std::log(1.0 / kRootCut) * along * along;
  const double discriminant = b * b + 4.0 * theta * c;
  // Where the wind alone would give the thrust the theory has long ended.
  const double tip_m_per_s = (b + std::sqrt(std::max(discriminant, 0.0))) / (2.0 * theta);
  flight.speed_rad_per_s = tip_m_per_s / rotors.radius_m;
  flight.advance_ratio = along / tip_m_per_s;
  const double growth = vehicle.linear_drag_N_s_per_m > 0.0
                            ? std::max(0.0, options.profile_power_growth - kInPlaneGrowth)
                            : options.profile_power_growth;
  flight.parasite_W = drag_N * airspeed_m_per_s;
  flight.induced_W = options.induced_power_factor * flight.thrust_N * induced;
  flight.profile_W = rotors.profile_W_s3 * std::pow(flight.speed_rad_per_s, 3) *
                     (1.0 + growth * flight.advance_ratio * flight.advance_ratio);
  flight.shaft_W = flight.parasite_W + flight.induced_W + flight.profile_W;
  SetMotors(vehicle, rotors, flight);
  return flight;
}

double PulseVoltage(const Vehicle& vehicle, const LevelFlight& flight, double battery_V) {
  const double diode_V = vehicle.esc.synchronous ? 0.0 : vehicle.esc.diode_V;
  // D (v_b + V_d) = u + R i + V_d, powertrain.h
  return (flight.battery_V + diode_V) * (battery_V / (battery_V + diode_V));
}

double BatteryPower(const Vehicle& vehicle, const LevelFlight& flight, double battery_V) {
  const double pulses_V = PulseVoltage(vehicle, flight, battery_V);
  const double switched_V = pulses_V < battery_V ? vehicle.esc.SwitchingShare() * battery_V : 0.0;
  return static_cast<double>(vehicle.rotor_count()) * (pulses_V + switched_V) * flight.motor_A +
         vehicle.avionics_power_W;  // (3.11)
}

std::optional<BestSpeeds> FindBestSpeeds(const Vehicle& vehicle,
                                         double battery_V,
                                         const LevelFlightOptions& options) {
  const auto possible = [&](double speed) {
    const LevelFlight flight = Cruise(vehicle, speed, options);
    return flight.battery_V <= battery_V && flight.advance_ratio <= kLargestAdvanceRatio;
  };
  if (!possible(0.0)) return std::nullopt;
  constexpr double kStep_m_per_s = 0.25;
  constexpr double kMost_m_per_s = 100.0;
  BestSpeeds best;
  // In a strong wind less power than in hover is needed, so that what is possible at first may end
  // and return: it ends at the first speed that is not.
  double fastest = 0.0;
  while (fastest < kMost_m_per_s && possible(fastest + kStep_m_per_s)) fastest += kStep_m_per_s;
  double high = fastest + kStep_m_per_s;
  for (int n = 0; n < 40; ++n) {
    const double middle = 0.5 * (fastest + high);
    (possible(middle) ? fastest : high) = middle;
  }
  best.fastest_m_per_s = fastest;
  const auto power = [&](double speed) {
    return BatteryPower(vehicle, Cruise(vehicle, speed, options), battery_V);
  };
  const auto least = [&](auto&& cost, double from) {
    constexpr int kBits = 26;  // half of a double's: a minimum is flat
    return boost::math::tools::brent_find_minima(cost, from, fastest, kBits).first;
  };
  best.endurance = Cruise(vehicle, least(power, 0.0), options);
  best.range = Cruise(
      vehicle,
      least([&](double speed) { return power(speed) / speed; }, std::min(0.1, 0.5 * fastest)),
      options);
  return best;
}

}  // namespace lipoid
