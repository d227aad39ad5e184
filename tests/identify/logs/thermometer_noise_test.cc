#include "identify/logs/thermometer_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "model/statistics/normal_noise.h"

namespace lipoid {
namespace {

// A cell that warms from 25 degC for ten minutes, and cools: towards 45 and back, 300 s. Its slope has an edge of
// 0.075 K/s.
double WarmingTruth(double time_s) {
  constexpr double kTau_s = 300.0;
  constexpr double kLoad_s = 600.0;
  const auto warm = [&](double t) { return 20.0 * (1.0 - std::exp(-t / kTau_s)); };
  if (time_s <= kLoad_s) return 25.0 + warm(time_s);
  return 25.0 + warm(kLoad_s) * std::exp(-(time_s - kLoad_s) / kTau_s);
}

struct NoisyWarming {
  std::vector<double> time_s, degC;
};
NoisyWarming ReadWarming(double rows_s, double noise_K) {
  NormalNoise normal(3, 0);
  NoisyWarming shown;
  for (double t = 0.0; t <= 3000.0; t += rows_s) {
    shown.time_s.push_back(t);
    shown.degC.push_back(WarmingTruth(t) + noise_K * normal());
  }
  return shown;
}

TEST(ThermometerNoise, IsSeenInWhatIsIndependentFromRowToRow) {
  for (const double noise_K : {0.02, 0.1, 0.5}) {
    // Of 3000 rows the median is known to 2 %.
    EXPECT_NEAR(ThermometerNoise(ReadWarming(1.0, noise_K).degC), noise_K, 0.06 * noise_K);
  }
  EXPECT_LT(ThermometerNoise(ReadWarming(1.0, 0.0).degC), 1e-4);
  EXPECT_EQ(ThermometerNoise(std::vector<double>(29, 1.0)), 0.0);
}

// The error that is left, beside that of the mean of so many rows of a straight line, and at the edge.
TEST(ThermometerNoise, IsTakenOutAndTheWarmingStays) {
  constexpr double kNoise_K = 0.1;
  for (const double rows_s : {1.0, 5.0}) {
    const NoisyWarming shown = ReadWarming(rows_s, kNoise_K);
    const auto smooth = WithoutThermometerNoise(shown.time_s, shown.degC, kNoise_K);
    ASSERT_EQ(smooth.size(), shown.degC.size());
    double square = 0.0;
    double worst = 0.0;
    for (std::size_t k = 0; k < smooth.size(); ++k) {
      const double error = smooth[k] - WarmingTruth(shown.time_s[k]);
      square += error * error;
      worst = std::max(worst, std::abs(error));
    }
    EXPECT_LT(std::sqrt(square / static_cast<double>(smooth.size())), 0.45 * kNoise_K) << rows_s;
    EXPECT_LT(worst, 2.5 * kNoise_K) << rows_s;  // of the rows themselves: 3.5
  }
}

// A step, which no parabola has, stays where it is.
TEST(ThermometerNoise, AStepStays) {
  NoisyWarming shown = ReadWarming(1.0, 0.0);
  NormalNoise normal(4, 0);
  for (std::size_t k = 0; k < shown.degC.size(); ++k)
    shown.degC[k] = (k < 1000 ? 10.0 : 12.0) + 0.05 * normal();
  const auto smooth = WithoutThermometerNoise(shown.time_s, shown.degC, 0.05);
  EXPECT_NEAR(smooth[999], 10.0, 0.2);
  EXPECT_NEAR(smooth[1000], 12.0, 0.2);
}

}  // namespace
}  // namespace lipoid
