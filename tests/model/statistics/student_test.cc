// Against the closed forms of one and two degrees of freedom, and the normal distribution.
#include "model/statistics/student.h"

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

}  // namespace
}  // namespace lipoid
