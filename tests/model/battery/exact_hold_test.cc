#include "model/battery/exact_hold.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "model/core/special_values.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;

// |z| from 1e-12 to 1e3, ten per decade, with those on both sides of where PhiSlope changes its
// form.
std::vector<double> Magnitudes() {
  std::vector<double> all = {0.999999, 1.0, 1.000001};
  for (int k = -120; k <= 30; ++k) all.push_back(std::pow(10.0, 0.1 * k));
  return all;
}

// sum_k z^k/(k+1)! and its derivative in extended precision, scaled by e^{-|z|/2} at most: for z <
// -1 the series cancels and the closed form does not.
long double PhiReference(long double z) { return std::expm1(z) / z; }

long double PhiSlopeReference(long double z) {
  if (std::abs(z) >= 4.0L) return (std::exp(z) * (z - 1.0L) + 1.0L) / (z * z);
  long double term = 0.5L;  // z^j/(j+2)!
  long double sum = 0.0L;
  for (int j = 0; j < 80; ++j) {
    sum += (j + 1) * term;
    term *= z / (j + 3);
  }
  return sum;
}

TEST(ExactHold, PhiHasAllDigitsFromTinyToHuge) {
  for (const double magnitude : Magnitudes()) {
    for (const double z : {-magnitude, magnitude}) {
      if (z > 700.0) continue;  // overflows
      const auto expected = static_cast<double>(PhiReference(z));
      // expm1 and the division: one rounding each.
      EXPECT_NEAR(Phi(z), expected, 2.0 * kEpsilon * expected) << z;
    }
  }
  EXPECT_EQ(Phi(0.0), 1.0);
}

TEST(ExactHold, PhiSlopeHasAllDigitsFromTinyToHuge) {
  for (const double magnitude : Magnitudes()) {
    for (const double z : {-magnitude, magnitude}) {
      if (z > 700.0) continue;
      const auto expected = static_cast<double>(PhiSlopeReference(z));
      // For |z| >= 1 the closed form subtracts at most 0.74 from 1: it loses a factor of 4 to 8.
      EXPECT_NEAR(PhiSlope(z), expected, 8.0 * kEpsilon * expected) << z;
    }
  }
  EXPECT_EQ(PhiSlope(0.0), 0.5);
}

// x' = -rate x + i from x = 0 and from x = 1, by their closed forms.
TEST(ExactHold, CoefficientsAreTheClosedForms) {
  for (const double rate_per_s : {1e-9, 1e-4, 0.037, 3.7, 4200.0}) {
    for (const double dt_s : {1e-3, 0.01, 1.0, 60.0, 3600.0}) {
      const auto [decay, gain] = ExactHold(rate_per_s, dt_s);
      const long double z = static_cast<long double>(rate_per_s) * dt_s;
      // The exponent is rounded to a double: e^-z inherits z * eps.
      EXPECT_NEAR(decay,
                  static_cast<double>(std::exp(-z)),
                  (2.0 + static_cast<double>(z)) * kEpsilon * decay);
      EXPECT_NEAR(gain, static_cast<double>(-std::expm1(-z) / rate_per_s), 4.0 * kEpsilon * gain);
    }
  }
}

TEST(ExactHold, ModeOfRateZeroIsAnIntegrator) {
  const auto [decay, gain] = ExactHold(0.0, 12.5);
  EXPECT_EQ(decay, 1.0);
  EXPECT_EQ(gain, 12.5);
}

TEST(ExactHold, ModeOfInfiniteRateIsAtRest) {
  const auto [decay, gain] = ExactHold(kInfinity, 0.01);
  EXPECT_EQ(decay, 0.0);
  EXPECT_EQ(gain, 0.0);
}

TEST(ExactHold, StepOfNoLengthChangesNothing) {
  const auto [decay, gain] = ExactHold(0.3, 0.0);
  EXPECT_EQ(decay, 1.0);
  EXPECT_EQ(gain, 0.0);
}

TEST(ExactHold, TwoStepsAreTheirSum) {
  // decay multiplies, gain of a then b: decay_b gain_a + gain_b.
  for (const double rate_per_s : {1e-7, 0.037, 3.7}) {
    const auto a = ExactHold(rate_per_s, 0.75);
    const auto b = ExactHold(rate_per_s, 2.5);
    const auto both = ExactHold(rate_per_s, 3.25);
    EXPECT_NEAR(both.decay, a.decay * b.decay, 8.0 * kEpsilon * both.decay);
    EXPECT_NEAR(both.gain, b.decay * a.gain + b.gain, 8.0 * kEpsilon * both.gain);
  }
}

// d decay/d rate = -dt e^{-rate dt}; d gain/d rate = -dt² phi'(-rate dt), here by extended
// precision.
TEST(ExactHold, DerivativesHaveAllDigitsForTinyAndLargeSteps) {
  using Jet = ceres::Jet<double, 1>;
  for (const double rate_per_s : {1e-10, 1e-6, 0.037, 30.0}) {
    for (const double dt_s : {0.01, 1.0, 60.0}) {
      const auto step = ExactHold(Jet(rate_per_s, 0), dt_s);
      const auto plain = ExactHold(rate_per_s, dt_s);
      EXPECT_EQ(step.decay.a, plain.decay);
      EXPECT_EQ(step.gain.a, plain.gain);
      const long double z = -static_cast<long double>(rate_per_s) * dt_s;
      const auto slope = static_cast<double>(-dt_s * std::exp(z));
      const double rounding = (8.0 - static_cast<double>(z)) * kEpsilon;
      EXPECT_NEAR(step.decay.v[0], slope, rounding * std::abs(slope));
      const auto gain_slope = static_cast<double>(-dt_s * (dt_s * PhiSlopeReference(z)));
      EXPECT_NEAR(step.gain.v[0], gain_slope, 16.0 * kEpsilon * std::abs(gain_slope))
          << rate_per_s << " " << dt_s;
    }
  }
}

}  // namespace
}  // namespace lipoid
