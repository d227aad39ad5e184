#include "model/statistics/interval_95.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace lipoid {
namespace {

// 1, 2, ..., n in an order of their own.
std::vector<double> Shuffled(int n) {
  std::vector<double> values;
  for (int k = 1; k <= n; ++k) values.push_back(k);
  std::shuffle(values.begin(), values.end(), std::mt19937(3));
  return values;
}

TEST(Interval95, PlacesAreSharesOfOneMoreThanThereAre) {
  auto values = Shuffled(39);  // 0.025 . 40 is the first place
  EXPECT_EQ(Interval95(values), std::pair(1.0, 39.0));
  values = Shuffled(79);
  EXPECT_EQ(Interval95(values), std::pair(2.0, 78.0));
  values = Shuffled(59);  // 0.025 . 60 is halfway between two places
  EXPECT_EQ(Interval95(values), std::pair(1.5, 58.5));
}

TEST(Interval95, OfFewItIsTheLeastAndTheGreatest) {
  for (const int n : {1, 2, 20, 38}) {
    auto values = Shuffled(n);
    EXPECT_EQ(Interval95(values), std::pair(1.0, double(n))) << n;
  }
  std::vector<double> none;
  EXPECT_TRUE(std::isnan(Interval95(none).first));
}

// What the places are for: the next number of the same kind lies within 95 times of 100.
TEST(Interval95, HoldsTheNextNumber) {
  std::mt19937_64 engine(5);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  constexpr int kTrials = 20000;
  int held = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<double> values(50);
    for (double& v : values) v = uniform(engine);
    const auto [low, high] = Interval95(values);
    const double next = uniform(engine);
    held += low <= next && next <= high ? 1 : 0;
  }
  // Three standard deviations of 20 000 trials.
  EXPECT_NEAR(held / double(kTrials), 0.95, 0.005);
}

}  // namespace
}  // namespace lipoid
