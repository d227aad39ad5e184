#include "model/battery/resistance.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

namespace lipoid {
namespace {

TEST(Resistance, NumberIsTheSameEverywhere) {
  const Resistance<double> resistance(0.03);
  EXPECT_TRUE(resistance.constant());
  for (const double soc : {-1.0, 0.0, 0.5, 1.0, 2.0}) EXPECT_EQ(resistance(soc), 0.03) << soc;
}

TEST(Resistance, TableIsLinearBetweenNodesAndConstantBeyondThem) {
  const Resistance<double> resistance({0.25, 0.5, 1.0}, {0.75, 0.25, 0.5});
  EXPECT_FALSE(resistance.constant());
  // Binary fractions throughout: exact.
  EXPECT_EQ(resistance(-3.0), 0.75);
  EXPECT_EQ(resistance(0.25), 0.75);
  EXPECT_EQ(resistance(0.375), 0.5);
  EXPECT_EQ(resistance(0.5), 0.25);
  EXPECT_EQ(resistance(0.75), 0.375);
  EXPECT_EQ(resistance(1.0), 0.5);
  EXPECT_EQ(resistance(1.5), 0.5);
}

TEST(Resistance, TableOfOneNodeIsConstant) {
  const Resistance<double> resistance({0.5}, {0.125});
  for (const double soc : {0.0, 0.5, 1.0}) EXPECT_EQ(resistance(soc), 0.125) << soc;
}

TEST(Resistance, DerivativesAreThoseOfTheStraightLine) {
  using Jet = ceres::Jet<double, 3>;  // A, and the two nodes around it
  const Resistance<Jet> resistance({0.0, 0.5, 1.0}, {Jet(0.5, 1), Jet(0.25, 2), Jet(0.75)});
  const Jet inside = resistance(Jet(0.125, 0));
  EXPECT_EQ(inside.a, 0.4375);
  EXPECT_EQ(inside.v[0], -0.5);  // (0.25 - 0.5)/0.5
  EXPECT_EQ(inside.v[1], 0.75);
  EXPECT_EQ(inside.v[2], 0.25);
  const Jet beyond = resistance(Jet(-1.0, 0));
  EXPECT_EQ(beyond.v[0], 0.0);
  EXPECT_EQ(beyond.v[1], 1.0);
}

}  // namespace
}  // namespace lipoid
