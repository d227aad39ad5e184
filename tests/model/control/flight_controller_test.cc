#include "model/control/flight_controller.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/analysis/poles.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

using test::kEpsilon;

const Vehicle& CoupledMambo() {
  static const Vehicle vehicle = LoadVehicle("mambo-coupled");
  return vehicle;
}

ControllerOptions Continuous() {
  ControllerOptions options;
  options.pwm = Pwm::kContinuous;
  return options;
}

MeasuredState AtHeight(double height_m, double battery_V = 4.2) {
  MeasuredState state;
  state.position_m[2] = -height_m;
  state.battery_V = battery_V;
  return state;
}

FlightController Hovering(const ControllerOptions& options,
                          double commanded_speed = test::HoverSpeed(CoupledMambo())) {
  FlightController controller(CoupledMambo(), LoadGains("aware"), options);
  controller.Reset(AtHeight(1.0), commanded_speed, HeldSpeed(CoupledMambo(), 4.2));
  return controller;
}

// What the commanded speeds of a quadrotor make.
Wrench<double> WrenchOfFour(const FlightController& controller) {
  PerMotor<double> squares;
  std::copy_n(controller.speed_squared().begin(), squares.size(), squares.begin());
  return WrenchOf(CoupledMambo(), squares);
}

// By the eigenvalue of the motors of the linearized vehicle, which knows of transistors in series.
TEST(FlightController, TheLagIsThatOfMotorsWithTheirSpeedControllers) {
  for (const double transistors_Ohm : {0.0, 0.1}) {
    Vehicle vehicle = LoadVehicle("mambo-thesis");
    vehicle.esc.resistance_Ohm = transistors_Ohm;
    const double lag_s = ResponseAtHover(vehicle, HoverAt(vehicle, 1.0)).altitude.lag_s;
    EXPECT_NEAR(MotorLag_s(vehicle), lag_s, 1e-12 * lag_s) << transistors_Ohm;
  }
}

TEST(FlightController, HoldsTheDutyOfItsTrim) {
  // At xi = 1, and where the battery gives so little that 2200 rad/s must be commanded to hover.
  for (const double commanded : {test::HoverSpeed(CoupledMambo()), 2200.0}) {
    FlightController controller = Hovering(Continuous(), commanded);
    for (int k = 0; k < 100; ++k) {
      for (const double duty : controller.Step({.altitude_m = 1.0}, AtHeight(1.0))) {
        ASSERT_NEAR(duty, HoldingVoltage(CoupledMambo(), commanded) / 4.2, 16.0 * kEpsilon) << k;
      }
      ASSERT_FALSE(controller.saturated());
    }
    // e_I0 = (g - u_0)/K_I, with u_0 the acceleration that the commanded speeds would give.
    const double thrust = 4.0 * CoupledMambo().thrust_coefficient_N_s2 * commanded * commanded;
    EXPECT_NEAR(
        controller.integrals().down, (9.81 - thrust / CoupledMambo().mass_kg) / 1.36, 1e-12);
  }
}

TEST(FlightController, CompensationCommandsWithTheMeasuredVoltage) {
  const double volts = HoldingVoltage(CoupledMambo(), test::HoverSpeed(CoupledMambo()));
  ControllerOptions options = Continuous();
  FlightController plain = Hovering(options);
  EXPECT_NEAR(plain.Step({.altitude_m = 1.0}, AtHeight(1.0, 3.5))[0], volts / 4.2, 1e-14);
  options.compensate = true;
  FlightController compensated = Hovering(options);
  EXPECT_NEAR(compensated.Step({.altitude_m = 1.0}, AtHeight(1.0, 3.5))[0], volts / 3.5, 1e-14);
  // Without a measurement it is as if not asked to.
  EXPECT_NEAR(compensated.Step({.altitude_m = 1.0}, AtHeight(1.0, 0.0))[0], volts / 4.2, 1e-14);
}

TEST(FlightController, IntegratesTheErrorsThatLast) {
  FlightController controller = Hovering(Continuous());
  MeasuredState state = AtHeight(0.9);
  state.angles_rad = {0.01, -0.02, 3e-4};  // of yaw, what its torque can do
  for (int k = 0; k < 40; ++k) {
    (void)controller.Step({.altitude_m = 1.0, .hold_position = false}, state);
  }
  // Down, the reference is 0.1 m less than the state, for 40 steps.
  EXPECT_NEAR(controller.integrals().down, -0.1 * 40 * kControlStep_s, 1e-14);
  const double expected[] = {-0.01, 0.02, -3e-4};
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(controller.integrals().angles[k], expected[k] * 40 * kControlStep_s, 1e-14) << k;
  }
}

// Far too low: the motors saturate, and the integral waits; close again, it moves again.
TEST(FlightController, IntegralsDoNotWindUp) {
  FlightController controller = Hovering(Continuous());
  (void)controller.Step({.altitude_m = 1.0}, AtHeight(0.99));
  const double before = controller.integrals().down;
  EXPECT_LT(before, 0.0);
  for (int k = 0; k < 200; ++k) (void)controller.Step({.altitude_m = 1.0}, AtHeight(-20.0));
  EXPECT_TRUE(controller.saturated());
  EXPECT_EQ(controller.integrals().down, before);
  (void)controller.Step({.altitude_m = 1.0}, AtHeight(30.0));  // shrinks even while saturated
  EXPECT_TRUE(controller.saturated());
  EXPECT_GT(controller.integrals().down, before);
  FlightController free(CoupledMambo(), LoadGains("aware"), [] {
    ControllerOptions options = Continuous();
    options.saturate = false;
    return options;
  }());
  free.Reset(AtHeight(1.0), test::HoverSpeed(CoupledMambo()), 4000.0);
  for (int k = 0; k < 200; ++k) (void)free.Step({.altitude_m = 1.0}, AtHeight(-20.0));
  EXPECT_NEAR(free.integrals().down, -21.0 * 200 * kControlStep_s, 1e-10);
}

// What is asked for in torque is given up last: thrust is lowered or raised until the squares fit
// between 0 and those of D = 1.
TEST(FlightController, KeepsItsTorqueWhereThrustSaturates) {
  const double highest = std::pow(HeldSpeed(CoupledMambo(), 4.2), 2);
  ControllerOptions clipped = Continuous();
  ControllerOptions free = Continuous();
  free.saturate = false;
  for (const double height : {-20.0, 40.0}) {  // full thrust, none
    MeasuredState state = AtHeight(height);
    state.angles_rad = {0.05, -0.03, 0.01};
    FlightController a = Hovering(clipped);
    FlightController b = Hovering(free);
    const auto duty = a.Step({.altitude_m = 1.0, .hold_position = false}, state);
    (void)b.Step({.altitude_m = 1.0, .hold_position = false}, state);
    EXPECT_TRUE(a.saturated());
    const auto given = WrenchOfFour(a);
    const auto wanted = WrenchOfFour(b);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_NEAR(
          given.torque_N_m[k], wanted.torque_N_m[k], 1e-15 + 1e-9 * std::abs(wanted.torque_N_m[k]));
      EXPECT_NE(wanted.torque_N_m[k], 0.0);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      EXPECT_GE(a.speed_squared()[i], 0.0);
      EXPECT_LE(a.speed_squared()[i], highest);
      EXPECT_GE(duty[i], 0.0);
      EXPECT_LE(duty[i], 1.0);
    }
  }
}

// Of yaw the motors have little: an absurd one takes its share, and roll and pitch keep theirs.
TEST(FlightController, BoundsTheYawTorqueAndNoOther) {
  MeasuredState state = AtHeight(1.0);
  state.angles_rad = {0.05, -0.03, 2.0};
  const FlightCommand command{.altitude_m = 1.0, .hold_position = false};
  ControllerOptions options = Continuous();
  FlightController bounded = Hovering(options);
  (void)bounded.Step(command, state);
  options.limit_reference = false;
  options.saturate = false;
  FlightController free = Hovering(options);
  (void)free.Step(command, state);
  const auto given = WrenchOfFour(bounded);
  const auto wanted = WrenchOfFour(free);
  const double limit =
      AngleReferenceLimits(CoupledMambo(), HeldSpeed(CoupledMambo(), 4.2))[2] * 1e-4;  // J_z
  EXPECT_LT(wanted.torque_N_m[2], -10.0 * limit);
  EXPECT_NEAR(given.torque_N_m[2], -limit, 1e-9 * limit);
  EXPECT_NEAR(given.thrust_N, wanted.thrust_N, 1e-12);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_NEAR(given.torque_N_m[k], wanted.torque_N_m[k], 1e-15);
  }
}

// More torque than four motors have: as much of it as there is, in its direction.
TEST(FlightController, ShrinksATorqueThatNoThrustMakesPossible) {
  FlightController controller = Hovering(Continuous());
  MeasuredState state = AtHeight(1.0);
  state.body_rates_rad_per_s = {3000.0, 0.0, 0.0};  // absurd, and braked
  const auto duty = controller.Step({.altitude_m = 1.0, .hold_position = false}, state);
  EXPECT_TRUE(controller.saturated());
  // A roll to the right is braked by the motors on the right, 1 and 2.
  EXPECT_NEAR(duty[0], 1.0, 1e-12);
  EXPECT_NEAR(duty[1], 1.0, 1e-12);
  EXPECT_NEAR(duty[2], 0.0, 1e-12);
  EXPECT_NEAR(duty[3], 0.0, 1e-12);
}

TEST(FlightController, ReferencesKeepWithinTheTorqueOfTheMotors) {
  const double hover = std::pow(test::HoverSpeed(CoupledMambo()), 2);
  const double highest = std::pow(HeldSpeed(CoupledMambo(), 4.2), 2);
  const double roll_limit = 4.0 * CoupledMambo().lever_m() *
                            CoupledMambo().thrust_coefficient_N_s2 *
                            std::min(hover, highest - hover) / CoupledMambo().inertia_kg_m2[0];
  FlightCommand command{.altitude_m = 1.0, .hold_position = false};
  command.roll_rad = 0.3;
  double most = 0.0;
  FlightController controller = Hovering(Continuous());
  for (int k = 0; k < 100; ++k) {
    (void)controller.Step(command, AtHeight(1.0));
    most = std::max(most, std::abs(controller.references().angles[0].acceleration));
  }
  EXPECT_GT(most, 0.1 * roll_limit);
  EXPECT_LT(most, 0.5 * roll_limit);
  ControllerOptions options = Continuous();
  options.limit_reference = false;
  FlightController free = Hovering(options);
  (void)free.Step(command, AtHeight(1.0));
  EXPECT_GT(free.references().angles[0].acceleration, roll_limit);
}

TEST(FlightController, PositionBecomesTiltTowardsTheTarget) {
  FlightController controller = Hovering(Continuous());
  for (int k = 0; k < 20; ++k) {
    (void)controller.Step({.altitude_m = 1.0, .x_m = 1.0, .y_m = -1.0}, AtHeight(1.0));
  }
  EXPECT_LT(controller.references().angles[1].value, 0.0);  // nose down, forward
  EXPECT_LT(controller.references().angles[0].value, 0.0);  // to the left
}

TEST(FlightController, DutiesAreIntegersOfTheHardwareUnlessAskedOtherwise) {
  FlightController controller = Hovering(ControllerOptions{});
  for (int k = 0; k < 50; ++k) {
    for (const double duty : controller.Step({.altitude_m = 1.0}, AtHeight(1.0 - 0.001 * k))) {
      const double pwm = 490.0 * duty + 10.0;
      ASSERT_NEAR(pwm, std::round(pwm), 1e-9);
    }
  }
}

}  // namespace
}  // namespace lipoid
