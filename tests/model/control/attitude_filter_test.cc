#include "model/control/attitude_filter.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/constants.h"

namespace lipoid {
namespace {

constexpr double kWeight = 0.001;
constexpr double kBand_m_per_s2 = 1.0;
using test::kDegree;
using test::kFlightStep_s;
constexpr Triple<double> kAtRest{};

Triple<double> GravityAt(const Triple<double>& angles_rad) {
  return Attitude<double>(angles_rad).ToBody({0.0, 0.0, -kGravity_m_per_s2});
}

TEST(AttitudeFilter, RecoversATiltInItsTimeConstant) {
  const Triple<double> tilt{0.2, -0.3, 0.0};
  AttitudeFilter filter(kWeight, kBand_m_per_s2, kFlightStep_s);
  filter.Reset({}, {});
  for (int k = 0; k < 1000; ++k) filter.Step(kAtRest, GravityAt(tilt));
  // After 5 s = dt/W a share of 1/e is left; (1 - W)^1000 differs from it by W/2 of itself.
  const double left = std::exp(-1.0);
  EXPECT_NEAR(filter.angles_rad()[0] / tilt[0], 1.0 - left, kWeight * left);
  EXPECT_NEAR(filter.angles_rad()[1] / tilt[1], 1.0 - left, kWeight * left);
  EXPECT_EQ(filter.angles_rad()[2], 0.0);
  for (int k = 0; k < 40'000; ++k) filter.Step(kAtRest, GravityAt(tilt));
  EXPECT_NEAR(filter.angles_rad()[0], tilt[0], 1e-12);
  EXPECT_NEAR(filter.angles_rad()[1], tilt[1], 1e-12);
}

TEST(AttitudeFilter, HeedsTheAccelerometerOnlyWhileItShowsGravity) {
  for (const double factor : {0.89, 1.11}) {
    AttitudeFilter filter(kWeight, kBand_m_per_s2, kFlightStep_s);
    filter.Reset({}, {});
    Triple<double> force = GravityAt({0.2, 0.1, 0.0});
    for (double& f : force) f *= factor;
    for (int k = 0; k < 100; ++k) filter.Step(kAtRest, force);
    EXPECT_EQ(filter.angles_rad(), (Triple<double>{})) << factor;
  }
}

// Large angles in all axes at once. The oracle is the motion from which the rates are made.
Triple<double> Angles(double t_s) {
  return {0.8 * std::sin(3.0 * t_s), 0.6 * std::sin(2.0 * t_s + 1.0), 0.5 * t_s};
}
Triple<double> Rates(double t_s) {
  const Triple<double> angle_rates{2.4 * std::cos(3.0 * t_s), 1.2 * std::cos(2.0 * t_s + 1.0), 0.5};
  return Attitude<double>(Angles(t_s)).BodyRates(angle_rates);
}
double ErrorAfter(double duration_s, double step_s) {
  AttitudeFilter filter(0.0, kBand_m_per_s2, step_s);
  filter.Reset(Angles(0.0), Rates(0.0));
  const auto steps = static_cast<int>(std::lround(duration_s / step_s));
  for (int k = 1; k <= steps; ++k) filter.Step(Rates(k * step_s), {});
  double worst = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    worst = std::max(worst, std::abs(filter.angles_rad()[axis] - Angles(duration_s)[axis]));
  }
  return worst;
}

TEST(AttitudeFilter, IntegratesTheGyroToSecondOrder) {
  const double coarse = ErrorAfter(4.0, 0.005);
  const double fine = ErrorAfter(4.0, 0.0025);
  EXPECT_LT(coarse, 0.02 * kDegree);
  EXPECT_NEAR(coarse / fine, 4.0, 0.1);  // the next order's share of 5 ms at 3 rad/s is 1.5 %
}

TEST(AttitudeFilter, AGyroBiasThatIsLeftBecomesATilt) {
  AttitudeFilter filter(kWeight, kBand_m_per_s2, kFlightStep_s);
  const Triple<double> bias{-0.0095, 0.0, 0.0};
  filter.Reset({}, bias);
  for (int k = 0; k < 40'000; ++k) filter.Step(bias, GravityAt({}));
  // Where the two steps of the filter cancel, after the second of them: b dt (1 - W)/W.
  EXPECT_NEAR(filter.angles_rad()[0], -0.0095 * kFlightStep_s * (1.0 - kWeight) / kWeight, 1e-12);
}

TEST(AttitudeFilter, TakesTheShortWayRound) {
  AttitudeFilter filter(kWeight, kBand_m_per_s2, kFlightStep_s);
  filter.Reset({179.0 * kDegree, 0.0, 0.0}, {});
  filter.Step(kAtRest, GravityAt({-179.0 * kDegree, 0.0, 0.0}));
  EXPECT_NEAR(filter.angles_rad()[0], (179.0 + 2.0 * kWeight) * kDegree, 1e-12);
}

TEST(AttitudeFilter, StaysFiniteAtThePole) {
  AttitudeFilter filter(kWeight, kBand_m_per_s2, kFlightStep_s);
  filter.Reset({}, {});
  for (int k = 0; k < 1000; ++k) filter.Step({1.0, 10.0, 10.0}, GravityAt({}));
  for (const double angle : filter.angles_rad()) EXPECT_TRUE(std::isfinite(angle));
  EXPECT_LE(std::abs(filter.angles_rad()[1]), kGimbalLock_rad);
}

}  // namespace
}  // namespace lipoid
