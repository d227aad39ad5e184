#include "model/vehicle/wind.h"

#include <gtest/gtest.h>

#include <boost/math/quadrature/ooura_fourier_integrals.hpp>
#include <cmath>
#include <functional>
#include <vector>

#include "model/core/errors.h"
#include "tests/support/constants.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

constexpr std::uint64_t kGustSeed = 20;
using test::kPi;

// The spectra of MIL-F-8785C for sigma = 1 and L/V = 1, over w > 0.
double Along(double w) { return 2.0 / kPi / (1.0 + w * w); }
double Across(double w) { return (1.0 + 3.0 * w * w) / (kPi * (1.0 + w * w) * (1.0 + w * w)); }

// Their autocorrelation, by a Fourier integral; 1 at zero.
double Autocorrelation(const std::function<double(double)>& spectrum, double lag) {
  if (lag == 0.0) return 1.0;
  static boost::math::quadrature::ooura_fourier_cos<double> integral(1e-9, 8);
  return integral.integrate(spectrum, lag).first;
}

double Mean(const std::vector<double>& x) {
  double sum = 0.0;
  for (const double v : x) sum += v;
  return sum / static_cast<double>(x.size());
}

double MeanProduct(const std::vector<double>& x, const std::vector<double>& y, std::size_t lag) {
  double sum = 0.0;
  for (std::size_t k = lag; k < x.size(); ++k) sum += x[k] * y[k - lag];
  return sum / static_cast<double>(x.size() - lag);
}

// How far the mean product of two independent pairs or of a Gaussian series with itself may be
// off: Var <= 2/N sum_k rho_k² (Bartlett), and sum rho_k² <= 2/theta (1 + theta) for both spectra.
// Four sigma.
double Tolerance(double theta, std::size_t count) {
  return 4.0 * std::sqrt(2.0 * (1.0 / theta + 1.0) / static_cast<double>(count));
}

class DrydenSteps : public testing::TestWithParam<double> {};

// Whatever the step: the same variance, the same memory.
TEST_P(DrydenSteps, HaveTheAutocorrelationOfTheSpectra) {
  const double theta = GetParam();
  const std::size_t count = 2'000'000;
  NormalNoise noise(kGustSeed, 1);
  DrydenAlong along;
  DrydenAcross across;
  along.Start(noise);
  across.Start(noise);
  std::vector<double> u;
  std::vector<double> v;
  for (std::size_t k = 0; k < count; ++k) {
    u.push_back(along.Step(theta, noise));
    v.push_back(across.Step(theta, noise));
  }
  for (const double way : {0.0, 0.5, 1.0, 2.0, 4.0}) {
    const auto lag = static_cast<std::size_t>(std::llround(way / theta));
    const double exact = static_cast<double>(lag) * theta;
    EXPECT_NEAR(MeanProduct(u, u, lag), Autocorrelation(Along, exact), Tolerance(theta, count))
        << "along, lag " << exact;
    EXPECT_NEAR(MeanProduct(v, v, lag), Autocorrelation(Across, exact), Tolerance(theta, count))
        << "across, lag " << exact;
    EXPECT_NEAR(MeanProduct(u, v, lag), 0.0, Tolerance(theta, count)) << "together, lag " << exact;
  }
}
INSTANTIATE_TEST_SUITE_P(OfAnyLength, DrydenSteps, testing::Values(0.005, 0.05, 0.5, 2.0));

// Steps of changing length are exact too: one of 1 after many of 0.01 is correlated as any other.
TEST(Dryden, MayChangeItsStep) {
  constexpr int kPairs = 50'000;
  NormalNoise noise(kGustSeed, 2);
  double product = 0.0;
  double square = 0.0;
  for (int k = 0; k < kPairs; ++k) {
    DrydenAcross across;
    across.Start(noise);
    double first = 0.0;
    for (int j = 0; j < 5; ++j) first = across.Step(0.01, noise);
    const double second = across.Step(1.0, noise);
    product += first * second;
    square += second * second;
  }
  // Independent pairs: the variance of the product is 1 + rho², that of the square 2.
  EXPECT_NEAR(product / kPairs, Autocorrelation(Across, 1.0), 4.0 * std::sqrt(2.0 / kPairs));
  EXPECT_NEAR(square / kPairs, 1.0, 4.0 * std::sqrt(2.0 / kPairs));
}

TEST(Dryden, StartsAsItGoesOn) {
  constexpr int kStarts = 100'000;
  NormalNoise noise(kGustSeed, 3);
  double square = 0.0;
  for (int k = 0; k < kStarts; ++k) {
    DrydenAcross across;
    across.Start(noise);
    const double v = across.Step(1e-6, noise);
    square += v * v;
  }
  EXPECT_NEAR(square / kStarts, 1.0, 4.0 * std::sqrt(2.0 / kStarts));
}

TEST(Dryden, OverNoWayDoesNotChange) {
  NormalNoise noise(kGustSeed, 4);
  DrydenAcross across;
  across.Start(noise);
  const double first = across.Step(0.0, noise);
  EXPECT_EQ(across.Step(0.0, noise), first);
  // Over a way of 1e-9 by sqrt(3 theta) at most, four sigma: the noise is not lost in rounding.
  const double next = across.Step(1e-9, noise);
  EXPECT_NE(next, first);
  EXPECT_NEAR(next, first, 4.0 * std::sqrt(3e-9));
}

TEST(Dryden, ForgetsOverALongWay) {
  constexpr int kCount = 100'000;
  NormalNoise noise(kGustSeed, 5);
  DrydenAcross across;
  double square = 0.0;
  double product = 0.0;
  double last = 0.0;
  for (int k = 0; k < kCount; ++k) {
    const double v = across.Step(k % 2 == 0 ? 60.0 : 1e6, noise);
    square += v * v;
    product += v * last;
    last = v;
  }
  EXPECT_NEAR(square / kCount, 1.0, 4.0 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(product / kCount, 0.0, 4.0 / std::sqrt(kCount));
}

TEST(Dryden, HasTheLengthsAndIntensitiesOfTheStandard) {
  constexpr double kDigits = 1e-12;  // conversions of feet
  const auto low = DrydenAt(0.0, 15.0);
  const auto ten_feet = DrydenAt(3.048, 15.0);
  EXPECT_EQ(low.horizontal_length_m, ten_feet.horizontal_length_m);
  EXPECT_NEAR(ten_feet.vertical_length_m, 3.048, kDigits);
  // At 1000 ft low and medium altitude meet: all lengths 1000 ft, all intensities alike.
  const auto top = DrydenAt(304.8, 15.0);
  EXPECT_NEAR(top.vertical_length_m, 304.8, kDigits);
  EXPECT_NEAR(top.horizontal_length_m, 304.8, 1e-9);
  EXPECT_NEAR(top.horizontal_sigma_m_per_s, top.vertical_sigma_m_per_s, kDigits);
  EXPECT_NEAR(top.vertical_sigma_m_per_s, 1.5, kDigits);
  // 100 ft, by hand: 0.2593 to the power of 1.2 is 0.19795342, of 0.4 0.58280196.
  const auto middle = DrydenAt(30.48, 10.0);
  EXPECT_NEAR(middle.horizontal_length_m / 30.48, 1.0 / 0.19795342, 1e-6);
  EXPECT_NEAR(middle.horizontal_sigma_m_per_s, 1.0 / 0.58280196, 1e-7);
}

TEST(Wind, WithoutGustsIsItsMean) {
  WindOptions options;
  options.wind_x_m_per_s = 3.0;
  options.wind_y_m_per_s = -0.1;
  options.wind_z_m_per_s = 0.7;
  Wind wind(options, kGustSeed);
  const Triple<double> mean{3.0, -0.1, 0.7};
  for (int k = 0; k < 10; ++k) EXPECT_EQ(wind.Step(1.0 * k, 3.0), mean);
  EXPECT_EQ(wind.mean_m_per_s(), mean);
}

// Long-lived components along the wind, short-lived ones along Z, each with its variance.
TEST(Wind, GustsHaveTheStandardsStatisticsAlongAndAcrossTheWind) {
  WindOptions options;
  options.wind_x_m_per_s = 6.0;
  options.wind_y_m_per_s = 8.0;
  options.gusts_m_per_s = 10.0;
  constexpr double kAltitude_m = 20.0;
  constexpr double kAirspeed_m_per_s = 10.0;
  constexpr double kStep_s = 0.1;
  constexpr std::size_t kCount = 1'000'000;
  Wind wind(options, kGustSeed, kStep_s);
  std::vector<double> u;
  std::vector<double> v;
  std::vector<double> w;
  for (std::size_t k = 0; k < kCount; ++k) {
    const auto now = wind.Step(kAltitude_m, kAirspeed_m_per_s);
    u.push_back(0.6 * (now[0] - 6.0) + 0.8 * (now[1] - 8.0));
    v.push_back(0.6 * (now[1] - 8.0) - 0.8 * (now[0] - 6.0));
    w.push_back(now[2]);
  }
  const auto at = DrydenAt(kAltitude_m, 10.0);
  const double theta = kAirspeed_m_per_s * kStep_s / at.horizontal_length_m;
  const double theta_w = kAirspeed_m_per_s * kStep_s / at.vertical_length_m;
  const double var = at.horizontal_sigma_m_per_s * at.horizontal_sigma_m_per_s;
  const double var_w = at.vertical_sigma_m_per_s * at.vertical_sigma_m_per_s;
  for (const std::size_t lag : {0U, 20U, 80U}) {
    const double steps = static_cast<double>(lag);
    EXPECT_NEAR(MeanProduct(u, u, lag) / var,
                Autocorrelation(Along, steps * theta),
                Tolerance(theta, kCount));
    EXPECT_NEAR(MeanProduct(v, v, lag) / var,
                Autocorrelation(Across, steps * theta),
                Tolerance(theta, kCount));
    EXPECT_NEAR(MeanProduct(w, w, lag) / var_w,
                Autocorrelation(Across, steps * theta_w),
                Tolerance(theta_w, kCount));
  }
  // The mean of the gusts is zero: the variance of a mean is Phi(0) pi/T, largest for u.
  const double mean_tolerance = 4.0 * std::sqrt(2.0 / (theta * kCount) * var);
  EXPECT_NEAR(Mean(u), 0.0, mean_tolerance);
  EXPECT_NEAR(Mean(v), 0.0, mean_tolerance);
  EXPECT_NEAR(Mean(w), 0.0, mean_tolerance);
}

TEST(Wind, GustsGoOnAtAStandstill) {
  WindOptions options;
  options.gusts_m_per_s = 5.0;
  Wind wind(options, kGustSeed);
  const auto first = wind.Step(1.0, 0.0);
  auto last = first;
  for (int k = 0; k < 20'000; ++k) last = wind.Step(1.0, 0.0);  // 100 s, four times L/sigma
  for (std::size_t axis = 0; axis < 3; ++axis) {
    EXPECT_GT(std::abs(last[axis] - first[axis]), 1e-3) << axis;
  }
}

TEST(Wind, IsTheSameForTheSameSeedOnly) {
  WindOptions options;
  options.gusts_m_per_s = 5.0;
  Wind one(options, kGustSeed);
  Wind same(options, kGustSeed);
  Wind other(options, kGustSeed + 1);
  int equal = 0;
  for (int k = 0; k < 1000; ++k) {
    const double altitude_m = 1.0 + 0.01 * k;
    const auto now = one.Step(altitude_m, 2.0);
    EXPECT_EQ(same.Step(altitude_m, 2.0), now);
    equal += other.Step(altitude_m, 2.0) == now ? 1 : 0;
  }
  EXPECT_EQ(equal, 0);
}

TEST(Wind, NeedsAStep) {
  EXPECT_NE(test::MessageOf<PreconditionError>([] { Wind({}, 1, 0.0); }).find("step_s > 0"),
            std::string::npos);
}

TEST(WindOptions, RefuseWhatNoAirDoes) {
  WindOptions options;
  SetOption(options, "gusts_m_per_s", "7.7");
  EXPECT_EQ(options.gusts_m_per_s, 7.7);
  EXPECT_THROW(SetOption(options, "gusts_m_per_s", "-1"), OptionError);
  EXPECT_THROW(SetOption(options, "wind_x_m_per_s", "nan"), OptionError);
}

}  // namespace
}  // namespace lipoid
