#include "model/control/position_controller.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "model/control/gains.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

// A point mass under a thrust that holds its height: horizontally a = -g tan of the tilt, by the
// rotation itself and not by the law's small angles. Angles are at once what is commanded.
std::array<double, 4> Flown(const PositionGains& gains, double heading, double seconds) {
  using Point = std::array<double, 4>;  // X, Y, X', Y'
  constexpr double kTargetX = 2.0;
  constexpr double kTargetY = -3.0;
  const auto derivative = [&](const Point& at, Point& dx) {
    const auto tilt =
        PositionControl(gains, heading, at[0] - kTargetX, at[1] - kTargetY, at[2], at[3]);
    const Eigen::Vector3d down = test::Rotation({tilt.roll_rad, tilt.pitch_rad, heading}).col(2);
    dx = {at[2], at[3], -9.81 * down[0] / down[2], -9.81 * down[1] / down[2]};
  };
  Point x{0.0, 0.0, 0.5, 0.5};
  test::RungeKutta4(derivative, x, 0.01, int(seconds * 100));
  return {x[0] - kTargetX, x[1] - kTargetY, x[2], x[3]};
}

TEST(PositionController, ArrivesInEveryHeading) {
  for (const auto& name : ShippedGainsNames()) {
    const PositionGains gains = LoadGains(name).position;
    for (const double heading : {0.0, 0.8, 1.57, 3.0, -2.2}) {
      for (const double left : Flown(gains, heading, 25.0)) {
        EXPECT_NEAR(left, 0.0, 1e-4) << name << ", heading " << heading;
      }
    }
  }
}

// Small errors: both poles where the gains put them, X'' = -g (K_p X + K_d X').
TEST(PositionController, IsTheLinearLawNearItsTarget) {
  const PositionGains gains{.proportional_rad_per_m = 0.2, .derivative_rad_s_per_m = 0.3};
  for (const double heading : {0.0, 1.1, -2.0}) {
    const double ex = 0.02, ey = -0.01, vx = 0.03, vy = 0.05;
    const auto tilt = PositionControl(gains, heading, ex, ey, vx, vy);
    const Eigen::Vector3d down = test::Rotation({tilt.roll_rad, tilt.pitch_rad, heading}).col(2);
    // Third order in tilts of 0.02.
    EXPECT_NEAR(-down[0], -(0.2 * ex + 0.3 * vx), 2e-5) << heading;
    EXPECT_NEAR(-down[1], -(0.2 * ey + 0.3 * vy), 2e-5) << heading;
  }
}

TEST(PositionController, SignsAreThoseOfAPilot) {
  const PositionGains gains{.proportional_rad_per_m = 0.2, .derivative_rad_s_per_m = 0.3};
  // Too far ahead, heading north: nose up.
  EXPECT_GT(PositionControl(gains, 0.0, 1.0, 0.0, 0.0, 0.0).pitch_rad, 0.0);
  // Too far to the right: roll to the left.
  EXPECT_LT(PositionControl(gains, 0.0, 0.0, 1.0, 0.0, 0.0).roll_rad, 0.0);
  // Heading east, what is too far north is on the left: roll to the right.
  EXPECT_GT(PositionControl(gains, 1.5707963, 1.0, 0.0, 0.0, 0.0).roll_rad, 0.0);
}

TEST(PositionController, TiltsNoMoreThanItMay) {
  const PositionGains gains{.proportional_rad_per_m = 0.2, .derivative_rad_s_per_m = 0.3};
  const auto tilt = PositionControl(gains, 0.0, 100.0, 100.0, 0.0, 0.0);
  EXPECT_EQ(tilt.pitch_rad, gains.tilt_limit_rad);
  EXPECT_EQ(tilt.roll_rad, -gains.tilt_limit_rad);
}

}  // namespace
}  // namespace lipoid
