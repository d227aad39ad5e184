#include "model/vehicle/ground.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

using State = PlantState<double>;

using test::kFlightStep_s;
// At rest: m g = k depth, and k = m (50 rad/s)².
constexpr double kRestDepth_m = kGravity_m_per_s2 / 2500.0;

// Nothing drives the motors.
const Plant& Fallen() {
  static const Plant plant(LoadVehicle("mambo-physical"), PlantOptions{});
  return plant;
}

State At(double down_m, const Triple<double>& angles) {
  State x{};
  x[plant::kPosition + 2] = down_m;
  for (std::size_t k = 0; k < 3; ++k) x[plant::kAngles + k] = angles[k];
  return x;
}

void ExpectAtRest(const State& x) {
  // e^{-35 t} of the slowest mode and e^{-118 t} of friction are long gone.
  constexpr double kGone = 1e-9;
  EXPECT_NEAR(x[plant::kPosition + 2], kRestDepth_m, kGone);
  EXPECT_NEAR(x[plant::kAngles], 0.0, kGone);
  EXPECT_NEAR(x[plant::kAngles + 1], 0.0, kGone);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(x[plant::kVelocity + k], 0.0, kGone) << k;
    EXPECT_NEAR(x[plant::kRates + k], 0.0, kGone) << k;
  }
}

TEST(Ground, AVehicleDroppedFromFiveCentimetresLandsAndLies) {
  State x = At(-0.05, {0.0, 0.0, 0.4});
  double deepest = 0.0;
  for (int k = 0; k < 600; ++k) {
    test::Fly(Fallen(), {}, x, kFlightStep_s, 1);
    deepest = std::max(deepest, x[plant::kPosition + 2]);
  }
  ExpectAtRest(x);
  EXPECT_EQ(x[plant::kPosition], 0.0);
  EXPECT_EQ(x[plant::kAngles + 2], 0.4);
  // It hits at sqrt(2 g 5 cm) = 1 m/s; without damping it would go 2 cm into the springs.
  EXPECT_GT(deepest, 1.2 * kRestDepth_m);
  EXPECT_LT(deepest, 0.02);
}

TEST(Ground, ATiltedVehicleRightsItself) {
  for (const Triple<double>& angles :
       {Triple<double>{0.3, -0.2, 0.0}, {-0.5, 0.0, 1.0}, {0.2, 0.6, -2.0}}) {
    State x = At(-0.05, angles);
    test::Fly(Fallen(), {}, x, kFlightStep_s, 600);
    ExpectAtRest(x);
  }
}

// A hard landing: from 1 m, tilted, moving sideways and spinning.
TEST(Ground, AHardLandingEndsAtRestToo) {
  State x = At(-1.0, {0.3, 0.2, 0.0});
  x[plant::kVelocity] = 2.0;
  x[plant::kVelocity + 1] = -1.0;
  x[plant::kRates + 2] = 5.0;
  test::Fly(Fallen(), {}, x, kFlightStep_s, 1200);
  ExpectAtRest(x);
  EXPECT_GT(x[plant::kPosition], 0.5);
  EXPECT_LT(x[plant::kPosition], 5.0);
}

// x' = v, v' = -mu g v/sqrt(v² + s²): the way is the integral of sqrt(v² + s²)/(mu g) over v.
TEST(Ground, FrictionStopsSliding) {
  constexpr double kSpeed = 1.5;
  constexpr double kSlip = 0.05;
  constexpr double kFriction = 0.6;
  State x = At(kRestDepth_m, {0.0, 0.0, 0.0});
  x[plant::kVelocity] = kSpeed * std::cos(0.7);
  x[plant::kVelocity + 1] = kSpeed * std::sin(0.7);
  test::Fly(Fallen(), {}, x, 0.001, 2000);
  ExpectAtRest(x);
  const double root = std::hypot(kSpeed, kSlip);
  const double way = 0.5 / (kFriction * kGravity_m_per_s2) *
                     (kSpeed * root + kSlip * kSlip * std::asinh(kSpeed / kSlip));
  const double tolerance = 1e-6 * way;  // RK4 at 1 ms and 118/s: (0.118)^4/120
  EXPECT_NEAR(x[plant::kPosition], way * std::cos(0.7), tolerance);
  EXPECT_NEAR(x[plant::kPosition + 1], way * std::sin(0.7), tolerance);
  EXPECT_NEAR(x[plant::kAngles + 2], 0.0, 1e-12);  // nothing turns it
}

TEST(Ground, FrictionStopsSpinning) {
  State x = At(kRestDepth_m, {0.0, 0.0, 0.0});
  x[plant::kRates + 2] = 10.0;
  test::Fly(Fallen(), {}, x, 0.001, 2000);
  ExpectAtRest(x);
  EXPECT_GT(x[plant::kAngles + 2], 0.0);
}

TEST(Ground, PushesOnlyFeetThatAreInIt) {
  const Vehicle v = LoadVehicle("mambo-physical");
  const auto reaction = [&](double down_m, double roll, double sinking) {
    return GroundContact<double>(
        v, {0.0, 0.0, down_m}, Attitude<double>(roll, 0.0, 0.0), {0.0, 0.0, sinking}, {});
  };
  EXPECT_EQ(reaction(-1e-9, 0.0, 5.0).force_N, (Triple<double>{0.0, 0.0, 0.0}));
  // At rest at its depth the ground bears the weight and turns nothing.
  const auto rest = reaction(kRestDepth_m, 0.0, 0.0);
  EXPECT_NEAR(rest.force_N[2], -v.mass_kg * kGravity_m_per_s2, 1e-14);
  EXPECT_NEAR(rest.torque_N_m[0], 0.0, 1e-16);
  EXPECT_NEAR(rest.torque_N_m[1], 0.0, 1e-16);
  // Rolled to the right only the right feet reach it, and are pushed back: to the left.
  const auto rolled = reaction(-0.005, 0.2, 0.0);
  EXPECT_LT(rolled.force_N[2], 0.0);
  EXPECT_LT(rolled.torque_N_m[0], 0.0);
  // Feet that leave are not held.
  EXPECT_EQ(reaction(0.001, 0.0, -1.0).force_N[2], 0.0);
}

TEST(Ground, IsNearWhereAFootCouldReachIt) {
  const Vehicle v = LoadVehicle("mambo-physical");
  EXPECT_TRUE(NearGround(v, -0.99 * v.arm_m));
  EXPECT_FALSE(NearGround(v, -1.01 * v.arm_m));
  // Standing on its side, the lowest foot is a lever below.
  EXPECT_NE(GroundContact<double>(
                v, {0.0, 0.0, -0.99 * v.lever_m()}, Attitude<double>(1.57, 0.0, 0.0), {}, {})
                .force_N[2],
            0.0);
}

}  // namespace
}  // namespace lipoid
