#include "model/vehicle/powertrain.h"

#include <gtest/gtest.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <random>

#include "model/battery/cell_file.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

constexpr unsigned kSeed = 20261120;

// v_b as a root: the voltage at which what the battery gives is what the motors take. Knows (3.9)
// and (3.11), not their solution.
double RootOfTheLoop(const Vehicle& v,
                     const Supply<double>& supply,
                     const PerMotor<double>& duty,
                     const PerMotor<double>& speed) {
  const auto surplus = [&](double voltage_V) {
    double current_A = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      current_A += duty[i] * (duty[i] * voltage_V - v.motor_constant_N_m_per_A * speed[i]) /
                   v.armature_resistance_Ohm;
    }
    return supply.voltage_V - supply.resistance_Ohm * current_A - voltage_V;
  };
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      surplus, -100.0, 100.0, boost::math::tools::eps_tolerance<double>(52), iterations);
  return 0.5 * (bracket.first + bracket.second);
}

TEST(Powertrain, ClosedFormIsTheRootOfTheLoop) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  std::mt19937 engine(kSeed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<double> resistances{0.0, 1e-3, 5.0};
  for (const auto& name : ShippedCellNames()) {
    resistances.push_back(LoadCell(name).series_resistance_Ohm(1.0));
  }
  for (const double resistance : resistances) {
    for (int draw = 0; draw < 50; ++draw) {
      const Supply<double> supply{3.0 + 1.2 * share(engine), resistance};
      PerMotor<double> duty;
      PerMotor<double> speed;
      for (std::size_t i = 0; i < 4; ++i) {
        duty[i] = share(engine);
        speed[i] = 4000.0 * share(engine);
      }
      const double voltage = LoopVoltage(v, supply, duty, speed);
      // The bracket of the root finder is 52 bits of up to 100 V wide at worst.
      ASSERT_NEAR(voltage, RootOfTheLoop(v, supply, duty, speed), 1e-13)
          << "R = " << resistance << ", draw " << draw;
      PerMotor<double> current;
      for (std::size_t i = 0; i < 4; ++i) {
        current[i] = ArmatureCurrent(v, duty[i] * voltage, speed[i]);
      }
      ASSERT_NEAR(voltage, supply.voltage_V - resistance * BatteryCurrent(duty, current), 1e-12);
    }
  }
}

TEST(Powertrain, AnIdealSourceKeepsItsVoltage) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  EXPECT_EQ(LoopVoltage(v, Supply<double>{3.7, 0.0}, {0.1, 1.0, 0.5, 0.7}, {0.0, 9e3, 1.0, 2e3}),
            3.7);
}

TEST(Powertrain, WithoutDutyNothingFlows) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  EXPECT_EQ(LoopVoltage(v, Supply<double>{3.7, 0.2}, {}, {2e3, 2e3, 2e3, 2e3}), 3.7);
  EXPECT_EQ(BatteryCurrent<double>({}, {1.0, 2.0, 3.0, 4.0}), 0.0);
}

// Rotors faster than their voltage push current back: the battery charges, and v_b rises above
// what it has at rest.
TEST(Powertrain, FastRotorsCharge) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  const PerMotor<double> duty{0.1, 0.1, 0.1, 0.1};
  const PerMotor<double> speed{2e3, 2e3, 2e3, 2e3};
  EXPECT_GT(LoopVoltage(v, Supply<double>{3.7, 0.2}, duty, speed), 3.7);
}

}  // namespace
}  // namespace lipoid
