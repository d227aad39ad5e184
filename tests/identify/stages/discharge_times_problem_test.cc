#include "identify/stages/discharge_times_problem.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "identify/optimizers/optimizers.h"
#include "model/battery/discharge_time.h"

namespace lipoid {
namespace {

constexpr double kTrueAlpha_C = 2400.0;
constexpr double kTrueBeta = 0.05;  // over the shortest time beta² L is 0.5: the two forms differ

// Times of (4.37) with errors of a percent, so that the least cost is not zero.
std::vector<DischargeTime> Times() {
  std::mt19937_64 engine(3);
  std::normal_distribution<double> error(0.0, 0.01);
  std::vector<DischargeTime> times;
  for (const double current_A : {0.6, 1.2, 2.4, 3.6, 4.8}) {
    times.push_back(
        {.file = "",
         .current_A = current_A,
         .time_s = ExactDischargeTime(kTrueAlpha_C, kTrueBeta, current_A) * (1.0 + error(engine))});
  }
  return times;
}

class DischargeTimesBy : public testing::TestWithParam<std::string> {};

// The same optimizers as for the pulses: each finds what the closed form, or Newton's method on the
// exact one, finds.
TEST_P(DischargeTimesBy, IsTheBestOfBothForms) {
  const auto times = Times();
  const OptimizerEntry& optimizer = FindOptimizer(GetParam());
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    const DischargeTimesOptions options{.form = form, .weighting = TimeWeighting::kRelative};
    const DischargeTimesResult best = FitDischargeTimes(times, options);
    const DischargeTimesProblem problem(times, options, {}, 2.0);
    const double least = problem.Cost(problem.Point(best.alpha_C, SteadyLag(best.beta_per_sqrt_s)));
    const OptimizationSummary found = optimizer.Minimize(problem, problem.Start());
    ASSERT_TRUE(found.usable()) << found.message;
    EXPECT_GT(least, 0.0);
    // 0.1 % of the cost, as for the pulses; its square root is what the parameters are off by.
    EXPECT_LE(found.cost, 1.001 * least);
    EXPECT_GE(found.cost, (1.0 - 1e-9) * least);
    EXPECT_NEAR(problem.Alpha(found.x), best.alpha_C, 1e-3 * best.alpha_C);
    EXPECT_NEAR(
        BetaOfSteadyLag(problem.Lag(found.x)), best.beta_per_sqrt_s, 0.02 * best.beta_per_sqrt_s);
  }
}

std::vector<std::string> NamesOfUnknowns() {
  std::vector<std::string> names;
  for (const auto& optimizer : Optimizers()) names.emplace_back(optimizer.name);
  return names;
}

INSTANTIATE_TEST_SUITE_P(All,
                         DischargeTimesBy,
                         testing::ValuesIn(NamesOfUnknowns()),
                         [](const auto& row) {
                           std::string name = row.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(DischargeTimesProblem, HasTheSlopesOfItsTimes) {
  const auto times = Times();
  for (const auto form : {DischargeForm::kSteady, DischargeForm::kExact}) {
    for (const auto weighting : {TimeWeighting::kSeconds, TimeWeighting::kRelative}) {
      const DischargeTimesProblem problem(times, {.form = form, .weighting = weighting});
      const Eigen::VectorXd x = problem.Start();
      Eigen::VectorXd gradient;
      const double cost = problem.Gradient(x, gradient);
      for (Eigen::Index k = 0; k < x.size(); ++k) {
        // Central differences of 1e-5 are good to 1e-10 of the third derivative, and to 1e-11 of
        // the cost by rounding.
        constexpr double kStep = 1e-5;
        Eigen::VectorXd up = x;
        Eigen::VectorXd down = x;
        up[k] += kStep;
        down[k] -= kStep;
        EXPECT_NEAR(gradient[k],
                    (problem.Cost(up) - problem.Cost(down)) / (2.0 * kStep),
                    1e-7 * (std::abs(gradient[k]) + cost));
      }
    }
  }
}

TEST(DischargeTimesProblem, KeepsAlphaWhereItIsGiven) {
  const auto times = Times();
  const DischargeTimesProblem problem(times, {}, 2500.0);
  EXPECT_EQ(problem.size(), 1);
  EXPECT_EQ(problem.Alpha(problem.Start()), 2500.0);
  EXPECT_NEAR(problem.Lag(problem.Start()), SteadyLag(kTypicalBeta), 1e-12);
}

}  // namespace
}  // namespace lipoid
