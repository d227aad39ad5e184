#include "model/vehicle/level_flight.h"

#include <cmath>

#include "model/core/errors.h"
#include "model/vehicle/motor.h"

namespace lipoid {
namespace {

constexpr double kRotors = 4.0;

}  // namespace

LevelFlight Hover(const Vehicle& vehicle) {
  Require(vehicle.mass_kg > 0.0 && vehicle.thrust_coefficient_N_s2 > 0.0 &&
              vehicle.motor_constant_N_m_per_A > 0.0,
          "a vehicle with mass, propellers and motors",
          {{"mass_kg", vehicle.mass_kg}});
  LevelFlight flight;
  flight.thrust_N = vehicle.mass_kg * kGravity_m_per_s2;
  flight.speed_rad_per_s =
      std::sqrt(flight.thrust_N / (kRotors * vehicle.thrust_coefficient_N_s2));  // (3.12)
  flight.motor_V = HoldingVoltage(vehicle, flight.speed_rad_per_s);              // (3.16)
  flight.motor_A = HoldingCurrent(vehicle, flight.speed_rad_per_s);              // (3.14)
  flight.shaft_W =
      kRotors * vehicle.torque_coefficient_N_m_s2 * std::pow(flight.speed_rad_per_s, 3);
  flight.battery_W = kRotors * flight.motor_V * flight.motor_A;  // (3.11)
  return flight;
}

}  // namespace lipoid
