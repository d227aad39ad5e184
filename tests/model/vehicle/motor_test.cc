#include "model/vehicle/motor.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <array>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;
constexpr double kRoundingOfRoot = 16.0 * kEpsilon;  // relative: a few products and one root

class Motor : public testing::TestWithParam<std::string> {
 protected:
  const Vehicle v_ = LoadVehicle(GetParam());
};

TEST_P(Motor, HeldSpeedIsThePrintedForm) {
  const double gamma =
      (std::pow(v_.motor_constant_N_m_per_A, 2) + v_.armature_resistance_Ohm * v_.friction_N_m_s) /
      (v_.armature_resistance_Ohm * v_.torque_coefficient_N_m_s2);
  EXPECT_NEAR(v_.gamma_rad_per_s(), gamma, kRoundingOfRoot * gamma);
  for (const double xi : {0.5, 0.8, 0.9, 1.0, 1.2}) {
    for (const double commanded : {100.0, 1000.0, 2000.0, 3000.0}) {
      const double printed =
          0.5 * (-gamma +
                 std::sqrt(gamma * gamma + 4.0 * xi * (commanded * commanded + gamma * commanded)));
      // The printed form subtracts gamma, up to 2e4 rad/s, from a number as large.
      EXPECT_NEAR(HeldSpeed(v_, xi * HoldingVoltage(v_, commanded)), printed, 4 * kEpsilon * gamma)
          << "xi = " << xi << ", commanded " << commanded;
    }
  }
}

TEST_P(Motor, HeldSpeedAndHoldingVoltageAreInverse) {
  for (const double speed : {1e-6, 1.0, 500.0, 2000.0, 1e4}) {
    EXPECT_NEAR(HeldSpeed(v_, HoldingVoltage(v_, speed)) / speed, 1.0, kRoundingOfRoot) << speed;
  }
  for (const double voltage : {1e-9, 0.01, 1.0, 4.2}) {
    EXPECT_NEAR(HoldingVoltage(v_, HeldSpeed(v_, voltage)) / voltage, 1.0, kRoundingOfRoot)
        << voltage;
  }
  EXPECT_EQ(HeldSpeed(v_, 0.0), 0.0);
}

TEST_P(Motor, AHeldSpeedDoesNotChange) {
  for (const double speed : {300.0, 2000.0, 4000.0}) {
    const double current = ArmatureCurrent(v_, HoldingVoltage(v_, speed), speed);
    EXPECT_NEAR(current / HoldingCurrent(v_, speed), 1.0, 1e3 * kEpsilon) << speed;
    // Against the acceleration that the current alone would give.
    const double alone = v_.motor_constant_N_m_per_A * current / v_.rotor_inertia_kg_m2;
    EXPECT_NEAR(
        RotorAcceleration(v_, HoldingCurrent(v_, speed), speed) / alone, 0.0, kRoundingOfRoot);
  }
}

// J^P w' = k_e/r_a (V - k_e w) - b w - k_N w² has two equilibria, w+ and w-, and between them
// (w - w+)/(w - w-) falls as e^{-(k_N/J^P)(w+ - w-) t}: no integrator needed.
TEST_P(Motor, SpinsUpAsTheRiccatiEquationSays) {
  const double voltage = HoldingVoltage(v_, 2000.0);
  const auto derivative = [&](const std::array<double, 1>& w, std::array<double, 1>& dw) {
    dw[0] = RotorAcceleration(v_, ArmatureCurrent(v_, voltage, w[0]), w[0]);
  };
  const double upper = 2000.0;
  const double lower = -v_.gamma_rad_per_s() - upper;  // the roots of w² + gamma w add to -gamma
  const double decay = v_.torque_coefficient_N_m_s2 / v_.rotor_inertia_kg_m2 * (upper - lower);
  std::array<double, 1> w{0.0};
  for (int tenth = 1; tenth <= 10; ++tenth) {
    test::RungeKutta4(derivative, w, 1e-4, 100);
    const double ratio = upper / lower * std::exp(-decay * 0.01 * tenth);
    // RK4 at 1e-4 s and time constants of 20 ms or more: (1/200)^4/120, relative.
    EXPECT_NEAR(w[0], (upper - ratio * lower) / (1.0 - ratio), 1e-8 * upper) << tenth;
  }
  test::RungeKutta4(derivative, w, 1e-3, 2000);
  EXPECT_NEAR(w[0], HeldSpeed(v_, voltage), 1e-11 * upper);
  // From above as well.
  w[0] = 4000.0;
  test::RungeKutta4(derivative, w, 1e-3, 2000);
  EXPECT_NEAR(w[0], HeldSpeed(v_, voltage), 1e-11 * upper);
}

TEST_P(Motor, DragBrakesARotorThatTurnsBackwards) {
  EXPECT_GT(RotorAcceleration(v_, 0.0, -2000.0), 0.0);
  EXPECT_EQ(RotorAcceleration(v_, 0.0, -2000.0), -RotorAcceleration(v_, 0.0, 2000.0));
}

TEST_P(Motor, HeldSpeedCanBeDifferentiated) {
  using Jet = ceres::Jet<double, 1>;
  for (const double voltage : {0.5, 2.0, 4.0}) {
    const auto numeric = test::Ridders([&](double x) { return HeldSpeed(v_, x); }, voltage, 0.1);
    const double slope = HeldSpeed(v_, Jet(voltage, 0)).v[0];
    EXPECT_NEAR(slope, numeric.value, 1e-9 * slope + 10.0 * numeric.error);
  }
}

INSTANTIATE_TEST_SUITE_P(Shipped,
                         Motor,
                         testing::ValuesIn(ShippedVehicleNames()),
                         [](const auto& vehicle) {
                           std::string name = vehicle.param;
                           for (char& c : name) c = c == '-' ? '_' : c;
                           return name;
                         });

}  // namespace
}  // namespace lipoid
