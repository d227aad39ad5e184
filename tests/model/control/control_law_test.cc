#include "model/control/control_law.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"
#include "tests/support/plant_flight.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;

using test::Mambo;

TEST(ControlLaw, WithoutErrorsItHovers) {
  const auto out = InnerLoops<double>(Mambo(), LoadGains("aware"), {}, {}, {});
  for (const double squared : SquaredSpeedsOf(Mambo(), out.wrench)) {
    EXPECT_NEAR(std::sqrt(squared), test::HoverSpeed(Mambo()), 8.0 * kEpsilon * 2000.0);
  }
  EXPECT_EQ(out.pseudo_control_down, 0.0);
}

TEST(ControlLaw, ErrorsAreReferenceLessState) {
  InnerLoopState<double> state{-1.0, 0.0, {0.1, 0.2, 0.3}, {}};
  InnerLoopReferences<double> reference;
  reference.down.value = -1.5;
  reference.angles[0].value = 0.4;
  const auto out = InnerLoops<double>(Mambo(), LoadGains("aware"), state, reference, {});
  EXPECT_EQ(out.down_error, -0.5);
  EXPECT_DOUBLE_EQ(out.angle_errors[0], 0.3);
  EXPECT_DOUBLE_EQ(out.angle_errors[1], -0.2);
  EXPECT_DOUBLE_EQ(out.angle_errors[2], -0.3);
}

// Each loop takes its own gains, and pushes towards its reference.
TEST(ControlLaw, EveryLoopPushesTowardsItsReferenceWithItsOwnGains) {
  const Gains gains = LoadGains("unaware");
  const auto hover = InnerLoops<double>(Mambo(), gains, {}, {}, {});
  {
    InnerLoopReferences<double> reference;
    reference.down.value = -1.0;  // one metre up
    const auto out = InnerLoops<double>(Mambo(), gains, {}, reference, {});
    EXPECT_EQ(out.pseudo_control_down, -gains.altitude.proportional);
    EXPECT_GT(out.wrench.thrust_N, hover.wrench.thrust_N);
  }
  for (std::size_t k = 0; k < 3; ++k) {
    const ErrorGains& own = k == 2 ? gains.yaw : gains.attitude;
    InnerLoopReferences<double> reference;
    reference.angles[k].value = 0.1;
    const auto out = InnerLoops<double>(Mambo(), gains, {}, reference, {});
    EXPECT_DOUBLE_EQ(out.pseudo_control_angles[k], 0.1 * own.proportional);
    EXPECT_DOUBLE_EQ(out.wrench.torque_N_m[k], 0.1 * own.proportional * Mambo().inertia_kg_m2[k]);
    InnerLoopState<double> turning{};
    turning.body_rates[k] = 0.2;
    EXPECT_DOUBLE_EQ(InnerLoops<double>(Mambo(), gains, turning, {}, {}).pseudo_control_angles[k],
                     -0.2 * own.derivative);
    ErrorIntegrals<double> integrals;
    integrals.angles[k] = 0.5;
    EXPECT_DOUBLE_EQ(InnerLoops<double>(Mambo(), gains, {}, {}, integrals).pseudo_control_angles[k],
                     0.5 * own.integral);
  }
}

// At xi = 1 and without motor lag the loop closed through the whole plant is the linear error
// dynamics of the gains, however large the motion: e(t) follows its own equation in every angle
// and in height.
TEST(ControlLaw, ClosedWithoutLagTheErrorsAreLinear) {
  Gains gains = LoadGains("aware");
  gains.attitude = {.proportional = 27.0, .integral = 27.0, .derivative = 9.0};  // poles at -3
  gains.yaw = gains.altitude = gains.attitude;
  const Plant plant(Mambo(), {.motor_lag = false, .drag = false, .ground = false});
  using Loop = std::array<double, plant::kStates + 4>;
  const auto derivative = [&](const Loop& at, Loop& change) {
    PlantState<double> x;
    std::copy_n(at.begin(), x.size(), x.begin());
    const InnerLoopState<double> state{x[plant::kPosition + 2],
                                       x[plant::kVelocity + 2],
                                       TripleAt(x, plant::kAngles),
                                       TripleAt(x, plant::kRates)};
    const ErrorIntegrals<double> integrals{
        at[plant::kStates],
        {at[plant::kStates + 1], at[plant::kStates + 2], at[plant::kStates + 3]}};
    const auto out = InnerLoops<double>(Mambo(), gains, state, {}, integrals);
    const auto squares = SquaredSpeedsOf(Mambo(), out.wrench);
    PlantInputs<double> in;
    in.supply = {Mambo().nominal_voltage_V, 0.0};
    for (std::size_t i = 0; i < 4; ++i) {
      ASSERT_GT(squares[i], 0.0) << "motor " << i + 1;
      in.duty[i] = DutyCycle(Mambo(), std::sqrt(squares[i]), 4.2);
    }
    PlantState<double> dx;
    plant.Derivative(x, in, dx);
    std::copy(dx.begin(), dx.end(), change.begin());
    change[plant::kStates] = out.down_error;
    for (std::size_t k = 0; k < 3; ++k) change[plant::kStates + 1 + k] = out.angle_errors[k];
  };
  Loop x{};
  const double start[4] = {0.5, 0.6, -0.5, 0.3};  // of Z and the angles, at rest
  x[plant::kPosition + 2] = start[0];
  for (std::size_t k = 0; k < 3; ++k) x[plant::kAngles + k] = start[k + 1];
  for (int tenth = 1; tenth <= 10; ++tenth) {
    test::RungeKutta4(derivative, x, 1e-3, 100);
    const double t = 0.1 * tenth;
    // Three poles at -p from rest: e(t)/e(0) = (1 + p t - p² t²) e^{-p t}.
    const double left = (1.0 + 3.0 * t - 9.0 * t * t) * std::exp(-3.0 * t);
    ASSERT_NEAR(x[plant::kPosition + 2], start[0] * left, 1e-9) << t;  // RK4 at 1 ms
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(x[plant::kAngles + k], start[k + 1] * left, 1e-9) << "angle " << k << ", " << t;
    }
  }
}

TEST(ControlLaw, CanBeDifferentiated) {
  using Jet = ceres::Jet<double, 1>;
  const Gains gains = LoadGains("aware");
  const auto speeds = [&](auto down, auto roll) {
    using T = decltype(down);
    const InnerLoopState<T> state{
        down, T(0.3), {roll, T(-0.2), T(0.4)}, {T(0.5), T(roll * 2.0), T(-0.3)}};
    return SquaredSpeedsOf(Mambo(), InnerLoops<T>(Mambo(), gains, state, {}, {}).wrench);
  };
  for (std::size_t i = 0; i < 4; ++i) {
    const auto in_down = test::Ridders([&](double z) { return speeds(z, 0.1)[i]; }, 0.2, 0.05);
    const auto in_roll = test::Ridders([&](double r) { return speeds(0.2, r)[i]; }, 0.1, 0.05);
    const double down = speeds(Jet(0.2, 0), Jet(0.1))[i].v[0];
    const double roll = speeds(Jet(0.2), Jet(0.1, 0))[i].v[0];
    EXPECT_NEAR(down, in_down.value, 1e-9 * std::abs(down) + 10 * in_down.error) << i;
    EXPECT_NEAR(roll, in_roll.value, 1e-9 * std::abs(roll) + 10 * in_roll.error) << i;
    EXPECT_GT(std::abs(down), 1e5);
  }
}

}  // namespace
}  // namespace lipoid
