#include "model/control/saturation.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "model/vehicle/allocation.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kDrawSeed;
constexpr double kLimit = 7e6;
constexpr double kRoundingOfThrust = 1e-15 * kLimit;

// How much a motor is above another: what makes torques.
double Spread(const PerMotor<double>& s) {
  const auto [low, high] = std::minmax_element(s.begin(), s.end());
  return *high - *low;
}

TEST(Desaturate, LeavesAloneWhatMotorsCanDo) {
  PerMotor<double> squares{0.0, 1e6, 5e6, kLimit};
  const auto before = squares;
  EXPECT_FALSE(Desaturate(squares, kLimit));
  EXPECT_EQ(squares, before);
}

// All torques stay where they can, in proportion where they cannot, and the thrust moves no
// further than it must.
TEST(Desaturate, GivesUpThrustBeforeTorque) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  std::mt19937 engine(kDrawSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 2.0);
  int kept = 0;
  int shrunk = 0;
  for (int draw = 0; draw < 1000; ++draw) {
    PerMotor<double> squares;
    for (double& s : squares) s = uniform(engine) * kLimit;
    const auto before = squares;
    const bool saturated = Desaturate(squares, kLimit);
    if (!saturated) {
      ASSERT_EQ(squares, before);
      continue;
    }
    for (const double s : squares) {
      ASSERT_GE(s, 0.0);
      ASSERT_LE(s, kLimit);
    }
    const double share = std::min(1.0, kLimit / Spread(before));
    (share < 1.0 ? shrunk : kept) += 1;
    const auto wanted = WrenchOf(v, before);
    const auto given = WrenchOf(v, squares);
    const double rounding = 16.0 * kRoundingOfThrust * v.thrust_coefficient_N_s2 * v.arm_m;
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_NEAR(given.torque_N_m[k], share * wanted.torque_N_m[k], rounding) << draw;
    }
    // One motor stands at an end of what it can: any nearer thrust would need less than 0 or more
    // than the limit.
    const auto [low, high] = std::minmax_element(squares.begin(), squares.end());
    ASSERT_TRUE(*low <= kRoundingOfThrust || *high >= kLimit - kRoundingOfThrust) << draw;
    if (share < 1.0) {
      ASSERT_NEAR(*low, 0.0, kRoundingOfThrust);
      ASSERT_NEAR(*high, kLimit, kRoundingOfThrust);
    }
  }
  EXPECT_GT(kept, 100);
  EXPECT_GT(shrunk, 100);
}

TEST(Desaturate, TakesOneMotorAlone) {
  std::array<double, 1> above{2.0 * kLimit};
  EXPECT_TRUE(Desaturate(above, kLimit));
  EXPECT_EQ(above[0], kLimit);
  std::array<double, 1> below{-1.0};
  EXPECT_TRUE(Desaturate(below, kLimit));
  EXPECT_EQ(below[0], 0.0);
}

// Where a motor is at its end the command no longer moves it.
TEST(Desaturate, HasTheSlopesOfWhatItDoes) {
  using Jet = ceres::Jet<double, 2>;
  constexpr double kStep = 1.0;
  const auto run = [](double a, double b) {
    std::array<double, 2> squares{a, b};
    (void)Desaturate(squares, kLimit);
    return squares;
  };
  for (const auto& [a, b] : {std::pair{1.2 * kLimit, 0.7 * kLimit},
                             {-0.3 * kLimit, 0.5 * kLimit},
                             {-0.4 * kLimit, 1.3 * kLimit},
                             {0.2 * kLimit, 0.9 * kLimit}}) {
    std::array<Jet, 2> jets{Jet(a, 0), Jet(b, 1)};
    (void)Desaturate(jets, kLimit);
    for (std::size_t i = 0; i < 2; ++i) {
      ASSERT_EQ(jets[i].a, run(a, b)[i]);
      const double in_a = (run(a + kStep, b)[i] - run(a - kStep, b)[i]) / (2.0 * kStep);
      const double in_b = (run(a, b + kStep)[i] - run(a, b - kStep)[i]) / (2.0 * kStep);
      // Differences of squares of 7e6 over 2: rounding of 1e-9.
      EXPECT_NEAR(jets[i].v[0], in_a, 1e-8) << a << ", " << b << ", motor " << i;
      EXPECT_NEAR(jets[i].v[1], in_b, 1e-8) << a << ", " << b << ", motor " << i;
    }
  }
}

TEST(MayIntegrate, ShrinksAnIntegralButDoesNotLetItGrowWhileSaturated) {
  EXPECT_TRUE(MayIntegrate(false, 1.0, 1.0));
  EXPECT_FALSE(MayIntegrate(true, 1.0, 1.0));
  EXPECT_FALSE(MayIntegrate(true, -1.0, -1.0));
  EXPECT_TRUE(MayIntegrate(true, 1.0, -1.0));
  EXPECT_TRUE(MayIntegrate(true, -1.0, 1.0));
}

}  // namespace
}  // namespace lipoid
