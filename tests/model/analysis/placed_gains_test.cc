#include "model/analysis/placed_gains.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/analysis/stability.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/f450.h"

namespace lipoid {
namespace {

// A quadrotor of 5 inch propellers: light, with motors four times as fast as the F450's.
Vehicle Racer() {
  Vehicle v = test::F450();
  v.name = "racer";
  v.mass_kg = 0.65;
  v.inertia_kg_m2 = {0.0022, 0.0025, 0.0042};
  v.arm_m = 0.11;
  v.thrust_coefficient_N_s2 = 1.6e-6;
  v.torque_coefficient_N_m_s2 = 2e-8;
  v.motor_constant_N_m_per_A = 0.00408;
  v.armature_resistance_Ohm = 0.06;
  v.friction_N_m_s = 2e-6;
  v.rotor_inertia_kg_m2 = 3.5e-6;
  v.nominal_voltage_V = 16.8;
  return v;
}

// (s + w)³ (tau s + 1 - 3 w tau) multiplied out is the loop's own tau s⁴ + s³ + K_edot s² + ...
TEST(PlacedGains, PutThreePolesWhereTheyAreWanted) {
  for (const double tau : {0.01, 0.04}) {
    for (const double w : {0.5, 3.0, 0.2 / tau}) {
      const ErrorGains gains = ThreePolesAt(w, tau);
      const auto p = [&](double s) {
        return tau * std::pow(s, 4) + std::pow(s, 3) + gains.derivative * s * s +
               gains.proportional * s + gains.integral;
      };
      for (const double s : {-2.0 * w, -0.5 * w, 0.3 * w, w, 7.0 * w}) {
        const double wanted = std::pow(s + w, 3) * (tau * s + 1.0 - 3.0 * w * tau);
        constexpr double kRounding = 1e-12;  // of the largest term
        EXPECT_NEAR(p(s), wanted, kRounding * std::pow(std::abs(s) + w, 3)) << s;
      }
    }
  }
}

TEST(PlacedGains, KeepAllLoopsDampedFromFullToEmpty) {
  for (const Vehicle& vehicle : {test::F450(), Racer(), LoadVehicle("mambo-coupled")}) {
    const Gains gains = PlaceGains(vehicle).gains;
    for (const double xi : {0.7, 0.8, 0.9, 1.0}) {
      for (const auto& loop : CheckLoops(vehicle, gains, {}, true, HoverAt(vehicle, xi))) {
        SCOPED_TRACE(vehicle.name + std::string(" ") + std::string(loop.loop));
        EXPECT_TRUE(loop.stable()) << xi;
        EXPECT_GT(loop.damping, 0.15) << xi;
        EXPECT_GT(loop.gain_margin_up, 2.0) << xi;
        EXPECT_LT(loop.gain_margin_down, 0.5) << xi;
        EXPECT_GT(loop.phase_margin_deg, 30.0) << xi;
      }
    }
  }
}

TEST(PlacedGains, FollowTheMotorsAndTheTorques) {
  Vehicle vehicle = test::F450();
  const PlacedGains placed = PlaceGains(vehicle);
  EXPECT_NEAR(placed.attitude_rad_per_s * placed.lag_s, 0.2, 1e-12);
  vehicle.rotor_inertia_kg_m2 *= 2.0;
  const PlacedGains slower = PlaceGains(vehicle);
  EXPECT_NEAR(slower.lag_s - 0.0025, 2.0 * (placed.lag_s - 0.0025), 1e-9);
  EXPECT_NEAR(slower.attitude_rad_per_s * slower.lag_s, 0.2, 1e-12);
  // A vehicle that is hard to turn is turned slowly: 0.1 rad asks for no more than references may.
  Vehicle heavy = test::F450();
  for (double& inertia : heavy.inertia_kg_m2) inertia *= 100.0;
  const PlacedGains turned = PlaceGains(heavy);
  const auto limits = AngleReferenceLimits(heavy, HeldSpeed(heavy, heavy.nominal_voltage_V));
  EXPECT_LT(turned.attitude_rad_per_s, placed.attitude_rad_per_s);
  EXPECT_NEAR(0.1 * turned.gains.attitude.proportional, limits[1], 1e-9 * limits[1]);
  EXPECT_NEAR(0.1 * turned.gains.yaw.proportional, limits[2], 1e-9 * limits[2]);
}

TEST(PlacedGains, AreTheDefaultOfVehiclesOtherThanTheThesis) {
  const Vehicle mambo = LoadVehicle("mambo-coupled");
  EXPECT_EQ(GainsFor("", mambo, "aware").name, "aware");
  EXPECT_EQ(GainsFor("", mambo, "unaware").name, "unaware");
  EXPECT_EQ(GainsFor("", test::F450(), "aware").name, "placed");
  EXPECT_EQ(GainsFor("placed", mambo, "aware").name, "placed");
  EXPECT_EQ(GainsFor("aware", test::F450(), "aware").attitude.proportional, 0.99);
  EXPECT_EQ(PlaceGains(test::F450())
                .Brief()
                .find("gains placed from the motors' lag of 42.1 ms: "
                      "poles of the attitude at 4.75 rad/s"),
            0U);
}

// Sensors and estimator: the noise moves a weak attitude loop by radians.
TEST(PlacedGains, HoverForTenMinutesBySensorsAlone) {
  for (const Vehicle& vehicle : {test::F450(), Racer()}) {
    for (const std::uint64_t seed : {1U, 2U, 3U}) {
      FlightSetup setup;
      setup.vehicle = vehicle;
      setup.gains = PlaceGains(vehicle).gains;
      setup.xi = 0.85;
      setup.estimate = true;
      setup.seed = seed;
      FlightPlan plan = FindManeuver("hover").plan({});
      plan.duration_s = 600.0;
      const FlightResult flight = Fly(setup, plan);
      EXPECT_EQ(flight.outcome, Outcome::kCompleted) << vehicle.name << seed << flight.reason;
      EXPECT_LT(flight.mse_pitch_deg2, 1.0) << vehicle.name << seed;
      EXPECT_LT(flight.mse_altitude_m2, 0.02 * 0.02) << vehicle.name << seed;
    }
  }
}

}  // namespace
}  // namespace lipoid
