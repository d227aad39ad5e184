#include "model/control/command_generation.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;

TEST(CommandGeneration, ADutyCycleGivesItsSpeedAtTheVoltageItWasMadeFor) {
  for (const auto& name : ShippedVehicleNames()) {
    const Vehicle v = LoadVehicle(name);
    for (const double voltage : {v.nominal_voltage_V, 3.7, 3.1}) {
      for (const double speed : {10.0, 1000.0, 2000.0, 3500.0}) {
        const double duty = DutyCycle(v, speed, voltage);
        // The printed form, (3.17), term by term.
        const double k_e = v.motor_constant_N_m_per_A;
        const double r_a = v.armature_resistance_Ohm;
        const double printed = 1.0 / (k_e * voltage) *
                               ((k_e * k_e + r_a * v.friction_N_m_s) * speed +
                                r_a * v.torque_coefficient_N_m_s2 * speed * speed);
        EXPECT_NEAR(duty / printed, 1.0, 8.0 * kEpsilon);
        EXPECT_NEAR(HeldSpeed(v, duty * voltage) / speed, 1.0, 16.0 * kEpsilon) << name;
      }
    }
  }
}

// A battery below its nominal voltage turns the motors slower than commanded, unless the measured
// voltage is used.
TEST(CommandGeneration, CompensationHoldsTheSpeedWhateverTheBatteryGives) {
  const Vehicle v = LoadVehicle("mambo-physical");
  constexpr double kSpeed = 1800.0;
  for (const double xi : {1.0, 0.9, 0.8}) {
    const double battery_V = xi * v.nominal_voltage_V;
    const double held = HeldSpeed(v, DutyCycle(v, kSpeed, v.nominal_voltage_V) * battery_V);
    const double compensated = HeldSpeed(v, DutyCycle(v, kSpeed, battery_V) * battery_V);
    EXPECT_NEAR(compensated, kSpeed, 1e-11);
    if (xi < 1.0) {
      EXPECT_LT(held, (1.0 - 0.5 * (1.0 - xi)) * kSpeed);
    }
  }
}

TEST(PulseWidth, RoundedIsTheNearestIntegerOfTheHardware) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  PulseWidth rounded(v, Pwm::kRounded);
  EXPECT_EQ(rounded(0.0), 0.0);
  EXPECT_EQ(rounded(1.0), 1.0);
  EXPECT_EQ(rounded(-0.2), 0.0);
  EXPECT_EQ(rounded(1.2), 1.0);
  double before = 0.0;
  for (int k = 0; k <= 3000; ++k) {
    const double duty = k / 3000.0;
    const double quantized = rounded(duty);
    const double pwm = 490.0 * quantized + 10.0;  // (6.1), as printed
    ASSERT_NEAR(pwm, std::round(pwm), 1e-10) << duty;
    ASSERT_LE(std::abs(quantized - duty), 0.5 / 490.0 + kEpsilon) << duty;
    ASSERT_GE(quantized, before);
    ASSERT_EQ(rounded(quantized), quantized);  // what the hardware does stays
    before = quantized;
  }
}

// Integers too, but what is lost in one step is made up in the next: sums never differ by more
// than half an integer.
TEST(PulseWidth, CarriedGivesTheMeanThatIsWanted) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  PulseWidth carried(v, Pwm::kCarried);
  double wanted = 0.0;
  double given = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double duty = 0.5 + 0.3 * std::sin(0.01 * k) + 1e-4 * (k % 7);
    const double out = carried(duty);
    const double pwm = 490.0 * out + 10.0;
    ASSERT_NEAR(pwm, std::round(pwm), 1e-10) << k;
    wanted += duty;
    given += out;
    ASSERT_LE(std::abs(wanted - given), 0.5 / 490.0 + 1e-11) << k;
  }
}

// At its ends nothing is carried that could not be given: it does not wind up.
TEST(PulseWidth, CarriedDoesNotWindUp) {
  const Vehicle v = LoadVehicle("mambo-thesis");
  PulseWidth carried(v, Pwm::kCarried);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(carried(1.5), 1.0);
  EXPECT_NEAR(carried(0.5), 0.5, 1.0 / 490.0);
  EXPECT_NEAR(carried(0.5), 0.5, 1.0 / 490.0);
  for (int k = 0; k < 100; ++k) EXPECT_EQ(carried(-1.0), 0.0);
  EXPECT_NEAR(carried(0.5), 0.5, 1.0 / 490.0);
}

TEST(PulseWidth, ContinuousIsTheDutyItself) {
  PulseWidth continuous(LoadVehicle("mambo-thesis"), Pwm::kContinuous);
  EXPECT_EQ(continuous(0.123456789), 0.123456789);
  EXPECT_EQ(continuous(-0.1), 0.0);
  EXPECT_EQ(continuous(1.1), 1.0);
}

}  // namespace
}  // namespace lipoid
