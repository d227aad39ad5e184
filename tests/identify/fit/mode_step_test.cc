#include "identify/fit/mode_step.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "model/battery/exact_hold.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

// A mode by an exponential of its own.
ModeStep OneMode(int m, double beta_per_sqrt_s, double dt_s) {
  const double mm = static_cast<double>(m) * static_cast<double>(m);
  const double z = mm * beta_per_sqrt_s * beta_per_sqrt_s * dt_s;
  return DiffusionStep(mm, beta_per_sqrt_s, dt_s, -std::expm1(-z));
}

TEST(ModeStep, SlopesAreThoseOfTheCoefficients) {
  for (const double dt_s : {0.01, 1.0, 60.0, 3600.0}) {
    for (const double beta : {0.01, 0.2, 1.0}) {
      const ModeStep step = OneMode(3, beta, dt_s);
      const auto hold = ExactHold(9.0 * beta * beta, dt_s);
      EXPECT_NEAR(step.decay, hold.decay, 4e-16);
      EXPECT_NEAR(step.gain, hold.gain, 4e-16 * dt_s);
      const auto decay = [&](double b) { return OneMode(3, b, dt_s).decay; };
      const auto gain = [&](double b) { return OneMode(3, b, dt_s).gain; };
      // Ridders' extrapolation is good to some 1e-9 of the function over its argument.
      EXPECT_NEAR(step.decay_slope, test::Ridders(decay, beta, 0.1 * beta).value, 1e-8 / beta);
      EXPECT_NEAR(step.gain_slope, test::Ridders(gain, beta, 0.1 * beta).value, 1e-8 * dt_s / beta);
    }
    for (const double tau_s : {0.1, 45.0, 5000.0}) {
      const ModeStep step = LowPassStep(tau_s, dt_s);
      EXPECT_NEAR(step.decay + step.gain, 1.0, 1e-15);
      const auto decay = [&](double tau) { return LowPassStep(tau, dt_s).decay; };
      EXPECT_NEAR(step.decay_slope, test::Ridders(decay, tau_s, 0.1 * tau_s).value, 1e-8 / tau_s);
      EXPECT_EQ(step.gain_slope, -step.decay_slope);
    }
  }
}

// Where the closed form would cancel, and on either side of where the series ends: by the derivative
// of ExactHold() itself, with a scalar that carries one.
TEST(ModeStep, SlopesKeepTheirDigitsWhereTheStepIsShort) {
  using Jet = ceres::Jet<double, 1>;
  for (const double z : {1e-12, 1e-7, 1e-3, 0.0499, 0.0501, 0.3, 2.0, 40.0}) {
    const double beta = 0.2;
    const double dt_s = z / (4.0 * beta * beta);
    const Jet b(beta, 0);
    const auto hold = ExactHold(4.0 * b * b, dt_s);
    const ModeStep step = OneMode(2, beta, dt_s);
    // The decay has 16 digits behind the point: what has gone by e^-40 is gone.
    EXPECT_NEAR(step.decay_slope,
                hold.decay.v[0],
                1e-14 * std::abs(hold.decay.v[0]) + 4e-16 * z * 2.0 / beta)
        << z;
    // At z = 0.05 the closed form has lost 2.5 digits of 16.
    EXPECT_NEAR(step.gain_slope, hold.gain.v[0], 1e-13 * std::abs(hold.gain.v[0])) << z;
  }
}

// All modes by a recurrence that adds what is positive: each is that of an exponential of its own.
TEST(ModeStep, OfAllModesAreThoseOfEach) {
  constexpr int kModes = 40;
  ModeSteps steps;
  const std::vector<double> lengths_s{0.0, 1e-9, 1e-3, 0.01, 1.0, 7.3, 60.0, 3600.0, 1e6};
  for (const double beta : {1e-6, 0.01, 0.2, 1.0}) {
    steps.Resize(kModes, static_cast<Eigen::Index>(lengths_s.size()));
    for (std::size_t c = 0; c < lengths_s.size(); ++c) {
      const auto column = static_cast<Eigen::Index>(c);
      steps.SetDiffusion(column, beta, lengths_s[c]);
      for (int m = 1; m <= kModes; ++m) {
        const ModeStep one = OneMode(m, beta, lengths_s[c]);
        // A rounding for each step of the recurrence, relative to what has fallen.
        const double rounding = 2e-16 * m;
        EXPECT_NEAR(steps.decay(m - 1, column), one.decay, rounding * (1.0 - one.decay) + 2e-16);
        EXPECT_NEAR(steps.gain(m - 1, column), one.gain, (rounding + 4e-16) * one.gain);
        EXPECT_NEAR(steps.decay_slope(m - 1, column),
                    one.decay_slope,
                    2.0 * (rounding + 4e-16) * lengths_s[c] * m * m * beta);
        EXPECT_NEAR(
            steps.gain_slope(m - 1, column), one.gain_slope, 1e-12 * std::abs(one.gain_slope));
      }
    }
  }
}

}  // namespace
}  // namespace lipoid
