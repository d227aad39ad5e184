#include "identify/joint/capacity_reference.h"

#include <gtest/gtest.h>

namespace lipoid {
namespace {

TEST(JointGauge, FindsTheCutOffBetweenNodes) {
  const CutoffPoint p = FindCutoff({-0.1, 0.0, 0.1, 1.0}, {2.4, 2.9, 3.4, 4.2}, 3.0);
  EXPECT_TRUE(p.found);
  EXPECT_FALSE(p.extrapolated);
  EXPECT_EQ(p.lower, 1U);
  EXPECT_EQ(p.upper, 2U);
  EXPECT_NEAR(p.soc, 0.02, 1e-12);
}

TEST(JointGauge, GoesOnBelowNodesThatRowsHaveDetermined) {
  // Flat where no row went, then 10 V per unit of charge over a secant of 0.03.
  const CutoffPoint p =
      FindCutoff({0.0, 0.05, 0.06, 0.08, 0.5, 1.0}, {3.2, 3.2, 3.25, 3.5, 3.8, 4.2}, 3.0);
  EXPECT_TRUE(p.extrapolated);
  EXPECT_EQ(p.lower, 1U);
  EXPECT_EQ(p.upper, 3U);
  EXPECT_NEAR(p.soc, 0.05 - 0.2 / 10.0, 1e-12);
}

TEST(JointGauge, SlopesAreThoseOfItsOwnAnswer) {
  for (const double cutoff_V : {3.0, 2.0}) {
    const std::vector<double> soc{0.0, 0.1, 0.3, 1.0};
    const std::vector<double> voltage_V{2.8, 3.1, 3.5, 4.2};
    const CutoffPoint p = FindCutoff(soc, voltage_V, cutoff_V);
    constexpr double kStep_V = 1e-6;
    for (const bool upper : {false, true}) {
      auto above = voltage_V;
      auto below = voltage_V;
      above[upper ? p.upper : p.lower] += kStep_V;
      below[upper ? p.upper : p.lower] -= kStep_V;
      const double slope =
          (FindCutoff(soc, above, cutoff_V).soc - FindCutoff(soc, below, cutoff_V).soc) /
          (2.0 * kStep_V);
      EXPECT_NEAR(upper ? p.per_upper_V : p.per_lower_V, slope, 1e-8);
    }
  }
}

TEST(JointGauge, AFlatCurveNeverReachesIt) {
  EXPECT_FALSE(FindCutoff({0.0, 1.0}, {3.7, 3.7}, 3.0).found);
}

}  // namespace
}  // namespace lipoid
