#include "model/control/dynamic_inversion.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <random>

#include "model/control/command_generation.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

using State = PlantState<double>;
using TimeJet = ceres::Jet<double, 1>;

using test::kDrawSeed;
using test::kEpsilon;

// rho'' of the plant: the change of S(rho) Omega along its own motion, by automatic
// differentiation.
Triple<double> AngleAccelerations(const State& x, const State& dx) {
  Triple<TimeJet> angles;
  Triple<TimeJet> rates;
  for (std::size_t k = 0; k < 3; ++k) {
    angles[k] = TimeJet(x[plant::kAngles + k]);
    angles[k].v[0] = dx[plant::kAngles + k];
    rates[k] = TimeJet(x[plant::kRates + k]);
    rates[k].v[0] = dx[plant::kRates + k];
  }
  const auto angle_rates = Attitude<TimeJet>(angles).AngleRates(rates);
  return {angle_rates[0].v[0], angle_rates[1].v[0], angle_rates[2].v[0]};
}

class DynamicInversion : public testing::TestWithParam<std::string> {};

// The whole chain at xi = 1 with motors at their equilibrium: inversion, allocation, duty cycle,
// motor, forces, kinematics. What is asked for is what happens, in any attitude and motion.
TEST_P(DynamicInversion, CancelsTheDynamicsWithoutMotorLag) {
  const Vehicle v = LoadVehicle(GetParam());
  const Plant plant(v, {.motor_lag = false, .drag = false, .ground = false});
  std::mt19937 engine(kDrawSeed);
  int compared = 0;
  for (int draw = 0; draw < 400; ++draw) {
    const Triple<double> angles = test::RandomTriple(engine, 0.8);
    const Triple<double> rates = test::RandomTriple(engine, 3.0);
    // Yaw has the smallest authority: of the order of 10 rad/s².
    auto wanted = test::RandomTriple(engine, 20.0);
    wanted[2] *= 0.1;
    const double wanted_down = test::RandomTriple(engine, 3.0)[0];

    const Attitude<double> attitude(angles);
    const Wrench<double> wrench{InvertAttitude(v, attitude, rates, wanted),
                                InvertAltitude(v, attitude, wanted_down)};
    const auto squares = SquaredSpeedsOf(v, wrench);
    PlantInputs<double> in;
    in.supply = {v.nominal_voltage_V, 0.0};
    bool feasible = true;
    for (std::size_t i = 0; i < 4; ++i) {
      feasible = feasible && squares[i] > 0.0;
      if (feasible) in.duty[i] = DutyCycle(v, std::sqrt(squares[i]), v.nominal_voltage_V);
    }
    if (!feasible) continue;  // no motor turns backwards
    ++compared;

    State x{};
    for (std::size_t k = 0; k < 3; ++k) {
      x[plant::kAngles + k] = angles[k];
      x[plant::kRates + k] = rates[k];
    }
    x[plant::kVelocity + 2] = 1.0;
    State dx{};
    plant.Derivative(x, in, dx);
    const auto happened = AngleAccelerations(x, dx);
    // The moments are differences of four thrusts: rounding as of thrust times arm over inertia,
    // 500 rad/s² for roll and pitch, times a secant of 1.4.
    const double rounding = 64.0 * kEpsilon * wrench.thrust_N * v.arm_m / v.inertia_kg_m2[0];
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(happened[k], wanted[k], rounding) << "angle " << k << ", draw " << draw;
    }
    ASSERT_NEAR(dx[plant::kVelocity + 2], wanted_down, 64.0 * kEpsilon * 9.81) << draw;
  }
  EXPECT_GT(compared, 200);
}

INSTANTIATE_TEST_SUITE_P(Shipped,
                         DynamicInversion,
                         testing::Values("mambo-thesis", "mambo-coupled", "mambo-physical", "f450"),
                         [](const auto& vehicle) {
                           std::string name = vehicle.param;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

// Signs by hand: at rest and level the moments are J nu, and up is less.
TEST(Inversion, AtRestAndLevelIsInertiaTimesAcceleration) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  const Attitude<double> level(0.0, 0.0, 0.7);
  const auto torque = InvertAttitude(v, level, {0.0, 0.0, 0.0}, {1.0, 2.0, 3.0});
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_EQ(torque[k], v.inertia_kg_m2[k] * (double(k) + 1.0));
  }
  EXPECT_EQ(InvertAltitude(v, level, 0.0), v.mass_kg * kGravity_m_per_s2);
  EXPECT_EQ(InvertAltitude(v, level, kGravity_m_per_s2), 0.0);  // free fall
  EXPECT_GT(InvertAltitude(v, level, -1.0), v.mass_kg * kGravity_m_per_s2);
  const Attitude<double> tilted(0.5, 0.3, 0.0);
  EXPECT_NEAR(InvertAltitude(v, tilted, 0.0) * tilted.Down()[2],
              v.mass_kg * kGravity_m_per_s2,
              4.0 * kEpsilon);
}

}  // namespace
}  // namespace lipoid
