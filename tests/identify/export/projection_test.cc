// The one fit of all projected targets.
#include "identify/export/projection.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace lipoid {
namespace {

// A sum of squares of exact data ends where the slopes, which are differences, are rounded.
constexpr double kExact = 1e-7;

const std::vector<FreeParameter> kTwo = {{"a", 0.0, 10.0, 2.0}, {"b", -5.0, 5.0, 1.0}};

std::vector<double> Decay(const std::vector<double>& x) {
  std::vector<double> values;
  for (int k = 0; k < 50; ++k) values.push_back(x[0] * std::exp(-x[1] * 0.1 * k));
  return values;
}

TEST(Projection, FindsTheNumbersThatMadeTheData) {
  const auto found = Project(&Decay, Decay({3.0, 0.7}), kTwo, {{1.0, 0.0}});
  ASSERT_EQ(found.termination, Termination::kConverged) << found.message;
  EXPECT_NEAR(found.parameters[0], 3.0, kExact);
  EXPECT_NEAR(found.parameters[1], 0.7, kExact);
  EXPECT_TRUE(found.at_bound.empty());
}

TEST(Projection, StaysWithinItsBoundsAndSaysSo) {
  auto parameters = kTwo;
  parameters[0].upper = 2.5;
  const auto found = Project(&Decay, Decay({3.0, 0.7}), parameters, {{1.0, 0.0}});
  EXPECT_EQ(found.parameters[0], 2.5);
  EXPECT_EQ(found.at_bound, std::vector<std::string>{"a"});
  // The best b there: the slope of the squares vanishes.
  const auto cost = [&](double b) {
    double sum = 0.0;
    const auto law = Decay({2.5, b});
    const auto data = Decay({3.0, 0.7});
    for (std::size_t k = 0; k < law.size(); ++k) sum += std::pow(law[k] - data[k], 2);
    return sum;
  };
  const double b = found.parameters[1];
  EXPECT_LT(cost(b), cost(b + 1e-3));
  EXPECT_LT(cost(b), cost(b - 1e-3));
}

TEST(Projection, TakesTheBestOfItsStarts) {
  // Minima near -1 and 2, the one near 2 is deeper.
  const std::vector<FreeParameter> one = {{"x", -5.0, 5.0, 1.0}};
  const auto law = [](const std::vector<double>& x) {
    return std::vector<double>{(x[0] + 1.0) * (x[0] - 2.0), 0.1 * (x[0] - 2.0)};
  };
  const std::vector<double> zero{0.0, 0.0};
  EXPECT_LT(Project(law, zero, one, {{-3.0}}).parameters[0], -0.9);
  EXPECT_NEAR(Project(law, zero, one, {{-3.0}, {4.0}}).parameters[0], 2.0, 1e-5);
  EXPECT_NEAR(Project(law, zero, one, {{4.0}, {-3.0}}).parameters[0], 2.0, 1e-5);
}

TEST(Projection, ALawWithoutValuesIsAFailureAndNoException) {
  const auto law = [](const std::vector<double>&) {
    return std::vector<double>(3, std::numeric_limits<double>::quiet_NaN());
  };
  const auto found = Project(law, std::vector<double>(3, 1.0), kTwo, {{1.0, 1.0}});
  EXPECT_EQ(found.termination, Termination::kFailure);
  EXPECT_FALSE(found.message.empty());
}

TEST(Projection, GivesTheSameBitsAgain) {
  const auto data = Decay({3.0, 0.7});
  EXPECT_EQ(Project(&Decay, data, kTwo, {{1.0, 0.0}}).parameters,
            Project(&Decay, data, kTwo, {{1.0, 0.0}}).parameters);
}

}  // namespace
}  // namespace lipoid
