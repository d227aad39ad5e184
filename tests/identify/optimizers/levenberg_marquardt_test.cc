#include "identify/optimizers/levenberg_marquardt.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

#include "tests/identify/optimizers/nist_problems.h"
#include "tests/identify/optimizers/test_problems.h"

namespace lipoid {
namespace {

using test::DenseProblem;
using test::LinearProblem;
using test::MakeNistProblem;
using test::Rosenbrock;

Eigen::VectorXd Gradient(const DenseProblem& problem, const Eigen::VectorXd& x) {
  const Eigen::MatrixXd factor = problem.Factor(x, true);
  return factor.leftCols(problem.size()).transpose() * factor.rightCols(1);
}

// Karush-Kuhn-Tucker: no slope where x is free, none that leads back inside where it is bound.
void ExpectKkt(const DenseProblem& problem, const Eigen::VectorXd& x, double slope_tolerance) {
  const Eigen::VectorXd gradient = Gradient(problem, x);
  for (int k = 0; k < problem.size(); ++k) {
    ASSERT_GE(x[k], problem.lower()[k]);
    ASSERT_LE(x[k], problem.upper()[k]);
    if (x[k] == problem.lower()[k]) {
      EXPECT_GE(gradient[k], -slope_tolerance) << "at its lower bound: " << k;
    } else if (x[k] == problem.upper()[k]) {
      EXPECT_LE(gradient[k], slope_tolerance) << "at its upper bound: " << k;
    } else {
      EXPECT_NEAR(gradient[k], 0.0, slope_tolerance) << "free: " << k;
    }
  }
}

class NistStrd : public testing::TestWithParam<test::NistProblem> {};

// The cost is stationary: its last 1e-12 hold the sixth digit of the parameters.
constexpr double kSharp = 1e-15;

TEST_P(NistStrd, IsSolvedToSixDigits) {
  const test::NistProblem& nist = GetParam();
  constexpr double kSixDigits = 1e-6;
  for (const auto& start : nist.starts) {
    const DenseProblem problem = MakeNistProblem(nist);
    const Eigen::VectorXd from =
        Eigen::Map<const Eigen::VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
    const auto fit = MinimizeLevenbergMarquardt(problem, from, {.function_tolerance = kSharp});
    EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
    for (std::size_t k = 0; k < start.size(); ++k) {
      EXPECT_NEAR(fit.x[static_cast<Eigen::Index>(k)],
                  nist.certified[k],
                  kSixDigits * std::abs(nist.certified[k]))
          << "b" << k + 1 << " from start b1 = " << start[0];
    }
    EXPECT_NEAR(
        2.0 * fit.cost, nist.certified_sum_of_squares, 1e-9 * nist.certified_sum_of_squares);
    EXPECT_EQ(fit.evaluations, problem.evaluations());
    EXPECT_EQ(fit.gradient_evaluations, problem.gradient_evaluations());
  }
}

INSTANTIATE_TEST_SUITE_P(LevenbergMarquardt,
                         NistStrd,
                         testing::ValuesIn(test::NistProblems()),
                         [](const auto& problem) { return problem.param.name; });

// Bounded linear least squares, whose optimum is found by trying every set of active bounds.
TEST(LevenbergMarquardt, FindsTheOptimumOfBoundedLinearProblems) {
  constexpr int kSize = 3;
  int at_bounds = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    std::mt19937 engine(seed);
    std::normal_distribution<double> normal;
    const Eigen::MatrixXd a =
        Eigen::MatrixXd::NullaryExpr(8, kSize, [&] { return normal(engine); });
    const Eigen::VectorXd b = Eigen::VectorXd::NullaryExpr(8, [&] { return 3.0 * normal(engine); });
    DenseProblem problem = LinearProblem(a, b);
    for (int k = 0; k < kSize; ++k) problem.Bound(k, -0.3, 0.5);

    double best_cost = std::numeric_limits<double>::infinity();
    Eigen::VectorXd best;
    for (int code = 0; code < 27; ++code) {
      Eigen::VectorXd x(kSize);
      std::vector<int> free;
      int rest = code;
      for (int k = 0; k < kSize; ++k, rest /= 3) {
        if (rest % 3 == 2) free.push_back(k);
        x[k] = rest % 3 == 0 ? -0.3 : rest % 3 == 1 ? 0.5 : 0.0;
      }
      if (!free.empty()) x(free) = a(Eigen::all, free).colPivHouseholderQr().solve(b - a * x);
      if (x.minCoeff() < -0.3 || x.maxCoeff() > 0.5) continue;
      const double cost = 0.5 * (a * x - b).squaredNorm();
      if (cost < best_cost) {
        best_cost = cost;
        best = x;
      }
    }

    const auto fit = MinimizeLevenbergMarquardt(
        problem, Eigen::VectorXd::Constant(kSize, 0.1), {.function_tolerance = kSharp});
    EXPECT_EQ(fit.termination, Termination::kConverged) << "seed " << seed << ": " << fit.message;
    // The square root of the relative change of the cost at which it stops, and a margin of 30.
    EXPECT_LT((fit.x - best).norm(), 1e-6) << "seed " << seed << ", expected " << best.transpose();
    EXPECT_NEAR(fit.cost, best_cost, 1e-12 * best_cost) << "seed " << seed;
    ExpectKkt(problem, fit.x, 2e-5);
    EXPECT_FALSE(problem.outside()) << "seed " << seed;
    for (int k = 0; k < kSize; ++k) at_bounds += best[k] == -0.3 || best[k] == 0.5;
  }
  EXPECT_GT(at_bounds, 60);  // of 180: the test is about bounds
}

TEST(LevenbergMarquardt, FollowsACurvedValleyAlongABound) {
  // Rosenbrock with x <= 0.5: the optimum is (0.5, 0.25); with y <= 0.25 besides, the same corner.
  for (const double upper_y : {kUnbounded, 0.25}) {
    DenseProblem problem = Rosenbrock();
    problem.Bound(0, -2.0, 0.5).Bound(1, -kUnbounded, upper_y);
    const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-1.2, 0.2));
    EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
    EXPECT_EQ(fit.x[0], 0.5);  // to the bit: the bound itself
    EXPECT_NEAR(fit.x[1], 0.25, 1e-8);
    EXPECT_NEAR(fit.cost, 0.125, 1e-12);
    ExpectKkt(problem, fit.x, 1e-6);
  }
}

TEST(LevenbergMarquardt, LeavesABoundAtWhichItStarted) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -1.2, 2.0).Bound(1, 0.0, 2.0);
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-1.2, 0.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_NEAR(fit.x[0], 1.0, 1e-8);
  EXPECT_NEAR(fit.x[1], 1.0, 1e-8);
}

TEST(LevenbergMarquardt, LeavesABoundThatItTouchedOnTheWay) {
  // The first Gauss-Newton steps of atan overshoot to a bound; the optimum is inside.
  DenseProblem problem(2, [](const auto& x, auto& r, auto* j) {
    r = Eigen::Vector2d(std::atan(x[0]) - 0.1 * x[1], 1.0 - x[1]);
    if (j != nullptr) {
      j->resize(2, 2);
      *j << 1.0 / (1.0 + x[0] * x[0]), -0.1, 0.0, -1.0;
    }
  });
  problem.Bound(0, -1.0, 6.0).Bound(1, 0.0, 3.0);
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(5.0, 0.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_NEAR(fit.x[0], std::tan(0.1), 1e-8);
  EXPECT_NEAR(fit.x[1], 1.0, 1e-8);
}

TEST(LevenbergMarquardt, StaysAtABoundWithEveryParameter) {
  DenseProblem problem = LinearProblem(Eigen::Matrix2d::Identity(), Eigen::Vector2d(5.0, -5.0));
  problem.Bound(0, 0.0, 1.0).Bound(1, 0.0, 1.0);
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(0.3, 0.3));
  EXPECT_EQ(fit.termination, Termination::kConverged);
  EXPECT_EQ(fit.x, Eigen::VectorXd(Eigen::Vector2d(1.0, 0.0)));
  EXPECT_NEAR(fit.cost, 0.5 * (16.0 + 25.0), 1e-12);
}

TEST(LevenbergMarquardt, TakesABoundThatLeavesNoRoom) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, 0.7, 0.7);
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_EQ(fit.x[0], 0.7);
  EXPECT_NEAR(fit.x[1], 0.49, 1e-7);  // 10 (x1 - 0.49) beside a cost of 0.045: sqrt(1e-12)/10
}

TEST(LevenbergMarquardt, ReachesABoundInFewSteps) {
  // A valley along which the cost falls towards a bound, in log x, as beta's does: x -> 1 from
  // below.
  DenseProblem problem(2, [](const auto& x, auto& r, auto* j) {
    const double beta = std::exp(x[0]);
    constexpr int kRows = 40;
    r.resize(kRows);
    if (j != nullptr) j->resize(kRows, 2);
    for (int k = 0; k < kRows; ++k) {
      const double t = 0.1 * (k + 1);
      // As if 1/beta² were -0.05: out of reach.
      const double lag = 1.0 / (beta * beta);
      r[k] = t * x[1] + (1.0 - std::exp(-t)) * lag - (2.0 * t - 0.05 * (1.0 - std::exp(-t)));
      if (j != nullptr) j->row(k) << -2.0 * lag * (1.0 - std::exp(-t)), t;
    }
  });
  problem.Bound(0, std::log(1e-4), 0.0).Bound(1, 0.0, kUnbounded);
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(std::log(0.2), 1.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_EQ(fit.x[0], 0.0);
  ExpectKkt(problem, fit.x, 1e-5);
  EXPECT_LE(fit.evaluations, 20);  // it took 45 when it searched along every projected step
}

TEST(LevenbergMarquardt, StartsInsideWhateverItIsGiven) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, 0.0, 2.0).Bound(1, 0.0, 2.0);
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-100.0, 100.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_FALSE(problem.outside());
  EXPECT_NEAR(fit.x[0], 1.0, 1e-8);
}

TEST(LevenbergMarquardt, SaysThatItFailedWhereTheStartHasNoValue) {
  for (const double nothing : {kNaN, std::numeric_limits<double>::infinity()}) {
    const DenseProblem problem(1, [nothing](const auto&, auto& r, auto* j) {
      r = Eigen::VectorXd::Constant(2, nothing);
      if (j != nullptr) *j = Eigen::MatrixXd::Constant(2, 1, nothing);
    });
    const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::VectorXd::Constant(1, 0.5));
    EXPECT_EQ(fit.termination, Termination::kFailure);
    EXPECT_FALSE(fit.usable());
    EXPECT_FALSE(fit.message.empty());
    EXPECT_EQ(fit.x[0], 0.5);
    EXPECT_TRUE(std::isnan(fit.cost)) << fit.cost;
    EXPECT_EQ(problem.evaluations(), 1);
  }
}

TEST(LevenbergMarquardt, PrintsNothing) {
  const DenseProblem nothing(1, [](const auto&, auto& r, auto* j) {
    r = Eigen::VectorXd::Constant(2, kNaN);
    if (j != nullptr) *j = Eigen::MatrixXd::Constant(2, 1, kNaN);
  });
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  static_cast<void>(MinimizeLevenbergMarquardt(nothing, Eigen::VectorXd::Constant(1, 0.5)));
  static_cast<void>(MinimizeLevenbergMarquardt(Rosenbrock(), Eigen::Vector2d(-1.2, 1.0)));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(LevenbergMarquardt, TurnsAwayFromWhereThereIsNoValue) {
  // sqrt(x) - 0.1 from x = 4: the first step would land at x < 0.
  const DenseProblem problem(1, [](const auto& x, auto& r, auto* j) {
    r = Eigen::VectorXd::Constant(1, std::sqrt(x[0]) - 0.1);
    if (j != nullptr) *j = Eigen::MatrixXd::Constant(1, 1, 0.5 / std::sqrt(x[0]));
  });
  const auto fit = MinimizeLevenbergMarquardt(problem, Eigen::VectorXd::Constant(1, 4.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_NEAR(fit.x[0], 0.01, 1e-9);
}

TEST(LevenbergMarquardt, KeepsToItsIterationsOverAllRounds) {
  for (const int most : {1, 2, 5, 10}) {
    DenseProblem problem = Rosenbrock();
    problem.Bound(0, -2.0, 0.5).Bound(1, -2.0, 0.2);
    const auto fit =
        MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-1.2, 0.2), {.max_iterations = most});
    EXPECT_LE(fit.iterations, most);
    EXPECT_LE(problem.evaluations(),
              most + 4);  // the start, every step, and one that confirms each of three rounds
    EXPECT_TRUE(fit.usable());
  }
  // Far from the optimum after two steps: it says so.
  const DenseProblem problem = Rosenbrock();
  const auto fit =
      MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-1.2, 1.0), {.max_iterations = 2});
  EXPECT_EQ(fit.termination, Termination::kMaxIterations);
  EXPECT_EQ(fit.iterations, 2);
}

TEST(LevenbergMarquardt, GivesTheSameBitsAgain) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 0.5);
  const auto first = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-1.2, 1.0));
  const auto second = MinimizeLevenbergMarquardt(problem, Eigen::Vector2d(-1.2, 1.0));
  EXPECT_EQ(first.x, second.x);
  EXPECT_EQ(first.cost, second.cost);
  EXPECT_EQ(first.evaluations, second.evaluations);
  EXPECT_EQ(first.message, second.message);
}

TEST(OptimizationSummary, IsNotUsableBeforeItRan) {
  const OptimizationSummary summary;
  EXPECT_EQ(summary.termination, Termination::kNotRun);
  EXPECT_FALSE(summary.usable());
  EXPECT_TRUE(std::isnan(summary.cost));
}

}  // namespace
}  // namespace lipoid
