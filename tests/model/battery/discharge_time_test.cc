#include "model/battery/discharge_time.h"

#include <gtest/gtest.h>

#include <boost/math/constants/constants.hpp>
#include <boost/math/special_functions/trigamma.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include "model/battery/cell_model.h"
#include "model/core/errors.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;
constexpr long double kLongPi = boost::math::constants::pi<long double>();
// Where the test steps into rounding alone: a handful of operations.
constexpr double kRoundingOfLag = 8 * kEpsilon;

// U(L) by its definition: the terms in long double, as many as still move, and the exact remainder
// of 2/(beta² k²) for those that have come to rest.
long double LagBySum(long double beta, long double time_s) {
  const long double x = beta * beta * time_s;
  const auto terms = static_cast<int>(std::ceil(std::sqrt(60.0L / x)));  // e^-60 = 1e-26
  long double sum = 0.0L;
  for (int k = terms; k >= 1; --k) sum += -std::expm1(-x * k * k) / (1.0L * k * k);
  sum += boost::math::trigamma(static_cast<long double>(terms) + 1.0L);
  return 2.0L * sum / (beta * beta);
}

TEST(UnavailableLag, IsTheSumOfAllModes) {
  for (const double beta : {1e-3, 0.02, 0.2, 1.0}) {
    // beta² L from 1e-7, where thousands of modes move, to where none does.
    for (double x = 1e-7; x < 1e3; x *= 1.7) {
      const double time_s = x / (beta * beta);
      const auto exact = static_cast<double>(LagBySum(beta, time_s));
      EXPECT_NEAR(UnavailableLag(beta, time_s), exact, kRoundingOfLag * exact)
          << "beta " << beta << ", x " << x;
    }
  }
}

TEST(UnavailableLag, HasNoSeamWhereItsFormChanges) {
  // Neighbours on both sides of beta² L = 0.25, where it rises by dU/dL = 2 sum e^{-k² x} = 2.545
  // per second.
  const double beta = 0.5;
  const double below = std::nextafter(1.0, 0.0);
  EXPECT_NEAR(UnavailableLag(beta, below), UnavailableLag(beta, 1.0), kRoundingOfLag * 6.1);
  const double step = 1e-6;
  EXPECT_NEAR((UnavailableLag(beta, 1.0 + step) - UnavailableLag(beta, 1.0 - step)) / (2.0 * step),
              std::sqrt(static_cast<double>(kLongPi) / 0.25) - 1.0,
              1e-8);  // rounding of the difference: 6 kEpsilon/step
}

TEST(UnavailableLag, RisesFromNothingToTheSteadyLag) {
  EXPECT_EQ(UnavailableLag(0.2, 0.0), 0.0);
  double before = 0.0;
  for (double time_s = 1e-3; time_s < 500.0; time_s *= 1.3) {
    const double lag = UnavailableLag(0.2, time_s);
    EXPECT_GT(lag, before) << time_s;
    before = lag;
  }
  EXPECT_DOUBLE_EQ(UnavailableLag(0.2, 1e6), SteadyLag(0.2));
  EXPECT_NEAR(SteadyLag(0.2), 82.246703342411321, 1e-13);  // pi²/0.12
}

TEST(UnavailableLag, RefusesWhatHasNoMeaning) {
  EXPECT_THROW(static_cast<void>(UnavailableLag(0.0, 1.0)), PreconditionError);
  EXPECT_THROW(static_cast<void>(UnavailableLag(0.2, -1.0)), PreconditionError);
  EXPECT_THROW(static_cast<void>(UnavailableLag(std::nan(""), 1.0)), PreconditionError);
}

TEST(UnavailableLag, IsWhatTheCellHoldsBack) {
  // 60 modes and the tail, 7 s steps: the mode beyond them has decayed by e^{-beta² 61² 7} =
  // e^-1042.
  CellParameters<double> parameters;
  parameters.alpha_C = 5000.0;
  parameters.beta_per_sqrt_s = 0.2;
  parameters.terms = 60;
  parameters.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  const CellModel<double> model(parameters);
  auto state = model.Relaxed(1.0);
  const auto step = model.MakeStep(7.0);
  for (int k = 1; k <= 100; ++k) {
    model.Advance(state, 2.5, step);
    EXPECT_NEAR(model.UnavailableCharge(state, 2.5) / 2.5,
                UnavailableLag(0.2, 7.0 * k),
                100 * kRoundingOfLag * SteadyLag(0.2))  // of at most 100 steps
        << k;
  }
}

TEST(BetaOfSteadyLag, UndoesSteadyLag) {
  for (const double beta : {1e-3, 0.2, 1.0}) {
    EXPECT_NEAR(BetaOfSteadyLag(SteadyLag(beta)), beta, kRoundingOfLag * beta);
  }
  EXPECT_EQ(BetaOfSteadyLag(0.0), std::numeric_limits<double>::infinity());
  EXPECT_EQ(BetaOfSteadyLag(-3.0), std::numeric_limits<double>::infinity());
}

TEST(SteadyDischargeTime, IsTheChargeLessTheLag) {
  EXPECT_DOUBLE_EQ(SteadyDischargeTime(10000.0, 0.2, 2.0), 5000.0 - SteadyLag(0.2));
  EXPECT_EQ(SteadyDischargeTime(10000.0, 0.2, 1000.0), 0.0);  // 10 s of charge, a lag of 82 s
}

TEST(ExactDischargeTime, SatisfiesItsEquation) {
  for (const double alpha : {100.0, 1353.6, 1e5}) {
    for (double beta = 1e-3; beta <= 1.0; beta *= 1.9) {
      for (double current_A = 0.01; current_A <= 500.0; current_A *= 3.1) {
        const double time_s = ExactDischargeTime(alpha, beta, current_A);
        const double target_s = alpha / current_A;
        ASSERT_GE(time_s, 0.0);
        ASSERT_LE(time_s, target_s);
        EXPECT_NEAR(time_s + UnavailableLag(beta, time_s), target_s, 2 * kRoundingOfLag * target_s)
            << "alpha " << alpha << ", beta " << beta << ", current " << current_A;  // (4.37)
      }
    }
  }
}

TEST(ExactDischargeTime, BecomesTheSteadyOneWhenItLastsLong) {
  // beta² L = 0.04 * 4918: e^-197 is left of the slowest mode.
  EXPECT_NEAR(ExactDischargeTime(10000.0, 0.2, 2.0),
              SteadyDischargeTime(10000.0, 0.2, 2.0),
              1e-11);  // (4.40)
  // Where the steady form has no time left, the exact one still has.
  EXPECT_EQ(SteadyDischargeTime(10000.0, 0.2, 200.0), 0.0);
  EXPECT_GT(ExactDischargeTime(10000.0, 0.2, 200.0), 1.0);
}

TEST(ExactDischargeTime, GrowsWithTheSquareOfTheChargeWhenItIsShort) {
  // L + U(L) = 2 sqrt(pi L)/beta up to e^{-pi²/(beta² L)}: a semi-infinite electrode.
  const double alpha = 10000.0;
  const double beta = 0.05;
  const double current_A = 100.0;
  const double expected_s =
      std::pow(alpha * beta / (2.0 * current_A), 2) / static_cast<double>(kLongPi);
  ASSERT_LT(beta * beta * expected_s, 0.01);
  EXPECT_NEAR(
      ExactDischargeTime(alpha, beta, current_A), expected_s, 4 * kRoundingOfLag * expected_s);
}

TEST(ExactDischargeTime, IsWhenTheCellIsEmpty) {
  CellParameters<double> parameters;
  parameters.alpha_C = 1353.6;
  parameters.beta_per_sqrt_s = 0.1924;
  parameters.terms = 80;
  parameters.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  const CellModel<double> model(parameters);
  for (const double current_A : {0.1, 3.6, 10.0}) {
    auto state = model.Relaxed(1.0);
    const auto step = model.MakeStep(ExactDischargeTime(1353.6, 0.1924, current_A));
    model.Advance(state, current_A, step);
    EXPECT_NEAR(model.Soc(state, current_A), 0.0, 80 * kRoundingOfLag)
        << current_A;  // a sum of 80 modes
  }
}

TEST(ExactDischargeTime, RefusesWhatHasNoMeaning) {
  EXPECT_THROW(static_cast<void>(ExactDischargeTime(0.0, 0.2, 1.0)), PreconditionError);
  EXPECT_THROW(static_cast<void>(ExactDischargeTime(100.0, 0.2, 0.0)), PreconditionError);
  EXPECT_THROW(static_cast<void>(ExactDischargeTime(100.0, 0.0, 1.0)), PreconditionError);
}

}  // namespace
}  // namespace lipoid
