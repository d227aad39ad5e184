#include "model/control/error_controller.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "model/control/gains.h"
#include "tests/support/plant_flight.h"

namespace lipoid {
namespace {

TEST(ErrorController, WeighsEachErrorWithItsOwnGain) {
  const ErrorGains gains{.proportional = 2.0, .integral = 3.0, .derivative = 5.0};
  EXPECT_EQ(PseudoControl(gains, 7.0, 0.0, 0.0, 0.0), 7.0);
  EXPECT_EQ(PseudoControl(gains, 0.0, 1.0, 0.0, 0.0), 3.0);
  EXPECT_EQ(PseudoControl(gains, 0.0, 0.0, 1.0, 0.0), 2.0);
  EXPECT_EQ(PseudoControl(gains, 0.0, 0.0, 0.0, 1.0), 5.0);
}

// y'' = nu with e = y_ref - y is e''' + K_edot e'' + K_e e' + K_I e = 0. With three poles at -p and
// e(0) = 1 at rest and without integral, e = (1 - p t + ...) in closed form.
TEST(ErrorController, ShapesTheErrorOfADoubleIntegrator) {
  constexpr double p = 4.0;
  const ErrorGains gains{.proportional = 3 * p * p, .integral = p * p * p, .derivative = 3 * p};
  // States: e_I, y, y'; reference: a parabola y_ref = t²/2, which y starts 1 below.
  using Loop = std::array<double, 4>;  // and the time
  Loop x{0.0, -1.0, 0.0, 0.0};
  const auto derivative = [&](const Loop& at, Loop& dx) {
    const double t = at[3];
    const double e = 0.5 * t * t - at[1];
    dx = {e, at[2], PseudoControl(gains, 1.0, at[0], e, t - at[2]), 1.0};
  };
  for (int tenth = 1; tenth <= 20; ++tenth) {
    test::RungeKutta4(derivative, x, 1e-3, 100);
    const double t = x[3];
    // From e_I(0) = 0, e_I'(0) = 1, e_I''(0) = 0: e_I = (t + p t²) e^{-p t}, e its derivative.
    const double e = (1.0 + p * t - p * p * t * t) * std::exp(-p * t);
    ASSERT_NEAR(0.5 * t * t - x[1], e, 1e-10) << t;  // RK4 at 1 ms: (4e-3)^4
  }
}

}  // namespace
}  // namespace lipoid
