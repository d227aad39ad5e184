#include "model/vehicle/level_flight.h"

#include <gtest/gtest.h>

#include "model/core/errors.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

// What the battery gives is what the propellers take, and what windings and friction lose.
TEST(LevelFlight, PowerOfHoverIsBalanced) {
  for (const std::string& name : ShippedVehicleNames()) {
    const Vehicle vehicle = LoadVehicle(name);
    const LevelFlight hover = Hover(vehicle);
    const double speed = hover.speed_rad_per_s;
    const double lost_W = hover.battery_W - hover.shaft_W;
    const double each_W = vehicle.armature_resistance_Ohm * hover.motor_A * hover.motor_A +
                          vehicle.friction_N_m_s * speed * speed;
    EXPECT_NEAR(lost_W, 4.0 * each_W, 1e-12 * hover.battery_W) << name;
    EXPECT_NEAR(
        4.0 * vehicle.thrust_coefficient_N_s2 * speed * speed, vehicle.mass_kg * 9.81, 1e-12)
        << name;
    EXPECT_GT(lost_W, 0.1 * hover.battery_W) << name;
  }
}

// Propellers alone: power goes with the weight to 3/2.
TEST(LevelFlight, LosslessHoverGoesWithTheWeightToThreeHalves) {
  Vehicle vehicle = LoadVehicle("mambo-physical");
  vehicle.armature_resistance_Ohm = 1e-12;
  vehicle.friction_N_m_s = 0.0;
  const double light_W = Hover(vehicle).battery_W;
  vehicle.mass_kg *= 4.0;
  EXPECT_NEAR(Hover(vehicle).battery_W, 8.0 * light_W, 1e-9 * light_W);
}

TEST(LevelFlight, AVehicleWithoutMassIsNone) {
  EXPECT_THROW((void)Hover(Vehicle{}), PreconditionError);
}

}  // namespace
}  // namespace lipoid
