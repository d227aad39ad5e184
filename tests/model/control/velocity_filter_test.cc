#include "model/control/velocity_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/constants.h"

namespace lipoid {
namespace {

constexpr double kFlowQ_m2_per_s2 = 0.09;
constexpr double kR_m2_per_s2 = 5.0;
using test::kFlightStep_s;

// P = P + Q - P²/(P + R) before an update: a quadratic equation.
TEST(VelocityFilter, ReachesTheSolutionOfTheRiccatiEquation) {
  VelocityFilter filter(kFlowQ_m2_per_s2, kR_m2_per_s2, kFlightStep_s);
  for (int k = 0; k < 1000; ++k) {
    filter.Predict({});
    filter.Update({});
  }
  const double before = 0.5 * (kFlowQ_m2_per_s2 + std::sqrt(kFlowQ_m2_per_s2 * kFlowQ_m2_per_s2 +
                                                            4.0 * kFlowQ_m2_per_s2 * kR_m2_per_s2));
  const double gain = before / (before + kR_m2_per_s2);
  constexpr double kRelative = 1e-13;  // rounding
  EXPECT_NEAR(filter.variance(), before - kFlowQ_m2_per_s2, kRelative * before);
  filter.Predict({});
  filter.Update({1.0, -2.0});
  EXPECT_NEAR(filter.velocity_m_per_s()[0], gain, kRelative);
  EXPECT_NEAR(filter.velocity_m_per_s()[1], -2.0 * gain, kRelative);
  // The figures that estimator.h gives.
  EXPECT_NEAR(gain, 0.125, 5e-4);
  EXPECT_NEAR(-kFlightStep_s / std::log(1.0 - gain), 0.037, 5e-4);
}

TEST(VelocityFilter, FollowsAKnownAccelerationAndItsWay) {
  VelocityFilter filter(kFlowQ_m2_per_s2, kR_m2_per_s2, kFlightStep_s);
  filter.Reset({1.0, 2.0}, {0.5, 0.0});
  for (int k = 1; k <= 400; ++k) {
    filter.Predict({3.0, -1.0});
    filter.Update({0.5 + 3.0 * k * kFlightStep_s, -1.0 * k * kFlightStep_s});
    filter.Integrate();
  }
  constexpr double kRounding = 1e-12;  // 400 sums of numbers below 10
  EXPECT_NEAR(filter.velocity_m_per_s()[0], 6.5, kRounding);
  EXPECT_NEAR(filter.velocity_m_per_s()[1], -2.0, kRounding);
  EXPECT_NEAR(filter.position_m()[0], 1.0 + 1.0 + 6.0, kRounding);
  EXPECT_NEAR(filter.position_m()[1], 2.0 - 2.0, kRounding);
}

TEST(VelocityFilter, GoesOnWithoutReadings) {
  VelocityFilter filter(kFlowQ_m2_per_s2, kR_m2_per_s2, kFlightStep_s);
  filter.Reset({}, {2.0, 0.0});
  for (int k = 0; k < 100; ++k) {
    filter.Predict({});
    filter.Integrate();
  }
  EXPECT_EQ(filter.velocity_m_per_s()[0], 2.0);
  EXPECT_NEAR(filter.position_m()[0], 1.0, 1e-14);
  EXPECT_NEAR(filter.variance(), 9.0, 1e-12);  // 100 Q
}

}  // namespace
}  // namespace lipoid
