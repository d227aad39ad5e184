#include "identify/health/followed_current.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <numeric>
#include <random>

namespace lipoid::test {
namespace {

constexpr double kResistance_Ohm = 0.02;
constexpr double kNoise_A = 0.15;
constexpr std::size_t kRows = 1000;
constexpr std::size_t kTakeOff = 50;
constexpr double kRow_s = 0.5;

struct Hover {
  Record shown;
  Column true_A;
};

// A rest and a hover whose current rises as the voltage falls. The sensor's noise is added to what flowed, or is
// part of it, and the voltage comes `late` rows after.
Hover Fly(bool noise_flows, std::size_t late, double voltage_noise_V) {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> normal(0.0, 1.0);
  Hover hover;
  for (std::size_t k = 0; k < kRows; ++k) {
    const double level_A = k < kTakeOff ? 0.0 : 12.0 + 2.0 * static_cast<double>(k) / kRows;
    const double noise_A = kNoise_A * normal(engine);
    hover.true_A.push_back(level_A + (noise_flows ? noise_A : 0.0));
    hover.shown.current_A.push_back(level_A + noise_A);
    hover.shown.time_s.push_back(kRow_s * static_cast<double>(k));
  }
  for (std::size_t k = 0; k < kRows; ++k) {
    const double then_A = hover.true_A[k < late ? 0 : k - late];
    hover.shown.voltage_V.push_back(4.0 - kResistance_Ohm * then_A +
                                    voltage_noise_V * normal(engine));
  }
  return hover;
}

FlightSamples Sampled(const Record& shown) {
  FlightSamples samples;
  samples.record = shown;
  samples.fresh.resize(shown.size());
  std::iota(samples.fresh.begin(), samples.fresh.end(), std::size_t{0});
  samples.voltage_update_s = samples.current_update_s = kRow_s;
  samples.edge_resistance_Ohm = kResistance_Ohm;
  samples.largest_A = 14.0;
  return samples;
}

// A walk of q variances of the noise a row is seen through the noise to sqrt(q) of it, to first order. Of this level
// the walk is small, and an eighth is a quarter of what the noise was.
TEST(FollowedCurrent, IsTheLevelWhereTheVoltageDoesNotFollowTheNoise) {
  const Hover hover = Fly(false, 0, 0.002);
  const auto found = TakeOutUnfollowed(Sampled(hover.shown));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->noise_A, kNoise_A, 4.0 * kNoise_A / std::sqrt(2.0 * kRows));
  double squares = 0.0;
  for (std::size_t k = 0; k < kRows; ++k)
    squares += (found->current_A[k] - hover.true_A[k]) * (found->current_A[k] - hover.true_A[k]);
  EXPECT_LT(std::sqrt(squares / kRows), 0.25 * kNoise_A);
  // The take-off stays where it was, to the row.
  EXPECT_LT(std::abs(found->current_A[kTakeOff - 1]), 3.0 * kNoise_A);
  EXPECT_GT(found->current_A[kTakeOff], 11.0);
}

// Of rows at equal steps the smoothed level has the sum of what was shown, between one jump and the next: the charge
// is what it was, but for rounding.
TEST(FollowedCurrent, KeepsTheCharge) {
  const Hover hover = Fly(false, 0, 0.002);
  const auto found = TakeOutUnfollowed(Sampled(hover.shown));
  ASSERT_TRUE(found.has_value());
  const auto sum = [](const Column& x) { return std::accumulate(x.begin(), x.end(), 0.0); };
  EXPECT_NEAR(sum(found->current_A), sum(hover.shown.current_A), 1e-6 * sum(hover.true_A));
}

TEST(FollowedCurrent, KeepsWhatTheVoltageFollowsEvenLate) {
  EXPECT_FALSE(TakeOutUnfollowed(Sampled(Fly(true, 0, 0.002).shown)).has_value());
  EXPECT_FALSE(TakeOutUnfollowed(Sampled(Fly(true, 2, 0.002).shown)).has_value());
}

// Noise of the current that is small beside that of the voltage does no harm, and nothing tells whose it is.
TEST(FollowedCurrent, KeepsWhatTheVoltageWouldNotShow) {
  EXPECT_FALSE(TakeOutUnfollowed(Sampled(Fly(false, 0, 0.05).shown)).has_value());
}

TEST(FollowedCurrent, KeepsAllWhereNothingTells) {
  const Hover hover = Fly(false, 0, 0.002);
  FlightSamples flat = Sampled(hover.shown);
  flat.edge_resistance_Ohm = 0.0;
  EXPECT_FALSE(TakeOutUnfollowed(flat).has_value());
  Record few;
  for (std::size_t k = 0; k < kTakeOff; ++k) {
    few.time_s.push_back(hover.shown.time_s[k]);
    few.current_A.push_back(hover.shown.current_A[k]);
    few.voltage_V.push_back(hover.shown.voltage_V[k]);
  }
  EXPECT_FALSE(TakeOutUnfollowed(Sampled(few)).has_value());
  Record steady = hover.shown;
  steady.current_A = Column(kRows, 12.0);
  EXPECT_FALSE(TakeOutUnfollowed(Sampled(steady)).has_value());
}

}  // namespace
}  // namespace lipoid::test
