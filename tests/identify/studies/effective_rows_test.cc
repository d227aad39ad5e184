#include "identify/studies/effective_rows.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace lipoid {
namespace {

// x(k+1) = phi x(k) + noise, whose correlation time is (1 + phi)/(1 - phi) exactly.
std::vector<double> Autoregressive(std::size_t rows, double phi, unsigned seed) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::vector<double> x(rows);
  double last = normal(engine) / std::sqrt(1.0 - phi * phi);
  for (double& value : x) value = last = phi * last + normal(engine);
  return x;
}

double CorrelationTime(double phi) { return (1.0 + phi) / (1.0 - phi); }

// The estimate's own scatter is about sqrt(4 W/N), W lags summed of some six correlation times.
double Scatter(double rows, double correlation_time) {
  return std::sqrt(24.0 * correlation_time / rows);
}
constexpr double kSigmas = 4.0;

TEST(EffectiveRows, OfWhiteNoiseAreItsRows) {
  const std::size_t rows = 100000;
  const double found = EffectiveRows({Autoregressive(rows, 0.0, 1)});
  EXPECT_NEAR(found / rows, 1.0, kSigmas * Scatter(rows, 1.0));
  EXPECT_LE(found, rows);
}

TEST(EffectiveRows, OfAnAutoregressionFollowItsCorrelationTime) {
  for (const double phi : {0.5, 0.9, 0.99}) {
    const std::size_t rows = 200000;
    const double expected = rows / CorrelationTime(phi);
    const double found = EffectiveRows({Autoregressive(rows, phi, 7)});
    EXPECT_NEAR(found / expected, 1.0, kSigmas * Scatter(rows, CorrelationTime(phi))) << phi;
  }
}

TEST(EffectiveRows, OfALongSeriesSurviveItsBlocks) {
  const std::size_t rows = 2500000;  // blocks of three rows
  const double phi = 0.98;
  const double expected = static_cast<double>(rows) / CorrelationTime(phi);
  const double found = EffectiveRows({Autoregressive(rows, phi, 3)});
  EXPECT_NEAR(found / expected, 1.0, kSigmas * Scatter(rows, CorrelationTime(phi)));
}

TEST(EffectiveRows, OfSeveralLogsAdd) {
  const std::size_t rows = 100000;
  const double expected = 3.0 * rows / CorrelationTime(0.9);
  const double found = EffectiveRows(
      {Autoregressive(rows, 0.9, 1), Autoregressive(rows, 0.9, 2), Autoregressive(rows, 0.9, 3)});
  EXPECT_NEAR(found / expected, 1.0, kSigmas * Scatter(3.0 * rows, CorrelationTime(0.9)));
}

TEST(EffectiveRows, StayBetweenOneAndTheRows) {
  std::vector<double> alternating(1000);
  for (std::size_t k = 0; k < alternating.size(); ++k) alternating[k] = k % 2 == 0 ? 1.0 : -1.0;
  EXPECT_DOUBLE_EQ(EffectiveRows({alternating}), 1000.0);

  std::vector<double> ramp(1000);
  for (std::size_t k = 0; k < ramp.size(); ++k) ramp[k] = static_cast<double>(k);
  EXPECT_GE(EffectiveRows({ramp}), 1.0);
  EXPECT_LT(EffectiveRows({ramp}), 10.0);

  EXPECT_DOUBLE_EQ(EffectiveRows({std::vector<double>(50, 0.0)}), 50.0);
  EXPECT_DOUBLE_EQ(EffectiveRows({}), 1.0);
}

}  // namespace
}  // namespace lipoid
