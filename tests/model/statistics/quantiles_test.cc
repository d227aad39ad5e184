// Against the closed forms of one and two degrees of freedom, and the normal distribution.
#include "model/statistics/quantiles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace lipoid {
namespace {

TEST(Student, IsTheClosedFormOfOneAndTwoDegreesOfFreedom) {
  for (const double p : {0.6, 0.9, 0.95, 0.975, 0.999}) {
    EXPECT_NEAR(StudentQuantile(1.0, p),
                std::tan(std::numbers::pi * (p - 0.5)),
                1e-12 * StudentQuantile(1.0, p));
    const double u = 2.0 * p - 1.0;
    EXPECT_NEAR(StudentQuantile(2.0, p), u * std::sqrt(2.0 / (1.0 - u * u)), 1e-12 / (1.0 - p));
    EXPECT_NEAR(StudentQuantile(3.5, 1.0 - p), -StudentQuantile(3.5, p), 1e-12 / (1.0 - p));
  }
}

TEST(Student, ReachIsThatOfTheNormalDistributionWhereMuchIsKnown) {
  // The normal quantile at 97.5 %, and Student's first correction to it, (z³ + z)/(4 n).
  constexpr double kNormal = 1.959963984540054;
  constexpr double kFreedom = 1e6;
  const double correction = (std::pow(kNormal, 3) + kNormal) / (4.0 * kFreedom);
  EXPECT_NEAR(Reach95(kFreedom), kNormal + correction, 1e-10);
  EXPECT_GT(Reach95(4.0), Reach95(5.0));
}

TEST(Quantiles, OfSquaresAreTheClosedFormsOfTwoDegreesOfFreedom) {
  for (const double p : {0.001, 0.05, 0.5, 0.9}) {
    EXPECT_NEAR(ChiSquaredPassed(2.0, p), -2.0 * std::log(p), 1e-12);
    // 2 and n degrees: (1 + 2 F/n)^(-n/2) = p.
    EXPECT_NEAR(FisherPassed(2.0, 7.0, p), 3.5 * (std::pow(p, -1.0 / 3.5) - 1.0), 1e-11 / p);
    // One of them is Student's number squared.
    EXPECT_NEAR(
        FisherPassed(1.0, 9.0, p), std::pow(StudentQuantile(9.0, 1.0 - 0.5 * p), 2), 1e-11 / p);
  }
}

}  // namespace
}  // namespace lipoid
