#include "identify/fit/bounded_quadratic.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <random>

#include "model/core/special_values.h"

namespace lipoid {
namespace {

// A'A of a random matrix, well conditioned, and a right side that pulls some unknowns below their
// bounds.
struct Problem {
  Eigen::MatrixXd G;
  Eigen::VectorXd g;
  Eigen::VectorXd lower;
};
Problem RandomProblem(int n, std::mt19937_64& engine) {
  std::normal_distribution<double> normal(0.0, 1.0);
  Eigen::MatrixXd a(2 * n + 1, n);
  for (double& x : a.reshaped()) x = normal(engine);
  Problem p{a.transpose() * a, Eigen::VectorXd(n), Eigen::VectorXd(n)};
  for (double& x : p.g) x = 3.0 * normal(engine);
  for (double& x : p.lower) x = normal(engine) > 1.0 ? -kInfinity : 0.3 * normal(engine);
  return p;
}

double Value(const Problem& p, const Eigen::VectorXd& x) {
  return 0.5 * x.dot(p.G * x) - p.g.dot(x);
}

TEST(BoundedQuadratic, IsTheUnconstrainedMinimumWhereNoBoundIsInTheWay) {
  std::mt19937_64 engine(1);
  Problem p = RandomProblem(12, engine);
  p.lower.setConstant(-kInfinity);
  const auto result = MinimizeBoundedQuadratic(p.G, p.g, p.lower);
  ASSERT_TRUE(result.solved);
  EXPECT_EQ(result.factorizations, 1);
  EXPECT_LT((p.G * result.x - p.g).norm(), 1e-12 * p.g.norm());  // rounding
}

// Every set of active bounds, tried one by one.
TEST(BoundedQuadratic, FindsWhatTryingEveryActiveSetFinds) {
  std::mt19937_64 engine(2);
  for (int trial = 0; trial < 100; ++trial) {
    const int n = 1 + trial % 7;
    const Problem p = RandomProblem(n, engine);
    double least = kInfinity;
    for (unsigned set = 0; set < (1U << n); ++set) {
      Eigen::MatrixXd G = p.G;
      Eigen::VectorXd g = p.g;
      bool possible = true;
      for (int k = 0; k < n; ++k) {
        if ((set >> k & 1U) == 0) continue;
        possible = possible && std::isfinite(p.lower[k]);
        G.row(k).setZero();
        G(k, k) = 1.0;
        g[k] = p.lower[k];
      }
      if (!possible) continue;
      const Eigen::VectorXd x = G.partialPivLu().solve(g);
      if ((x - p.lower).minCoeff() >= -1e-12) least = std::min(least, Value(p, x));
    }
    const auto result = MinimizeBoundedQuadratic(p.G, p.g, p.lower);
    ASSERT_TRUE(result.solved);
    EXPECT_GE((result.x - p.lower).minCoeff(), 0.0);
    EXPECT_NEAR(Value(p, result.x), least, 1e-11 * (1.0 + std::abs(least))) << "trial " << trial;
  }
}

// Unknowns whose columns are alike, as those of neighbouring nodes are, and noise: exchanges find no
// end, and what is found all the same meets the conditions of the minimum of a convex function.
TEST(BoundedQuadratic, EndsWhereExchangesDoNot) {
  std::mt19937_64 engine(7);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (int trial = 0; trial < 60; ++trial) {
    const int n = 20 + trial;
    Problem p = RandomProblem(n, engine);
    Eigen::MatrixXd a(n, n);
    for (int c = 0; c < n; ++c) {
      for (int r = 0; r < n; ++r)
        a(r, c) = std::exp(-0.5 * std::pow((r - c) / 6.0, 2)) + 1e-4 * normal(engine);
    }
    p.G = a.transpose() * a + 1e-9 * Eigen::MatrixXd::Identity(n, n);
    Eigen::VectorXd truth(n);
    for (double& x : truth) x = std::max(normal(engine), 0.0);
    Eigen::VectorXd y = a * truth;
    for (double& v : y) v += 0.3 * normal(engine);
    p.g = a.transpose() * y;
    p.lower.setZero();
    const Eigen::VectorXd upper = Eigen::VectorXd::Constant(n, 2.0);
    const auto result = MinimizeBoundedQuadratic(p.G, p.g, p.lower, {}, upper);
    ASSERT_TRUE(result.solved) << trial;
    EXPECT_GT(result.factorizations, 50 + 5 * n);
    const Eigen::VectorXd slope = p.G * result.x - p.g;
    const double rounding = 1e-12 * p.g.lpNorm<Eigen::Infinity>();
    for (int k = 0; k < n; ++k) {
      ASSERT_GE(result.x[k], 0.0);
      ASSERT_LE(result.x[k], upper[k]);
      EXPECT_TRUE(result.x[k] == 0.0 || slope[k] < rounding) << trial;
      EXPECT_TRUE(result.x[k] == upper[k] || slope[k] > -rounding) << trial;
    }
  }
}

TEST(BoundedQuadratic, MeetsTheOptimalityConditionsOfLargeProblems) {
  std::mt19937_64 engine(3);
  for (int trial = 0; trial < 30; ++trial) {
    const Problem p = RandomProblem(40 + 3 * trial, engine);
    const auto result = MinimizeBoundedQuadratic(p.G, p.g, p.lower);
    ASSERT_TRUE(result.solved);
    const Eigen::VectorXd gradient = p.G * result.x - p.g;
    for (Eigen::Index k = 0; k < p.g.size(); ++k) {
      EXPECT_GE(result.x[k], p.lower[k]);
      if (result.x[k] > p.lower[k]) {
        EXPECT_NEAR(gradient[k], 0.0, 1e-9);
      } else {
        EXPECT_GE(gradient[k], -1e-9);
      }
    }
  }
}

TEST(BoundedQuadratic, NeedsOneFactorizationFromItsOwnAnswer) {
  std::mt19937_64 engine(4);
  const Problem p = RandomProblem(60, engine);
  const auto first = MinimizeBoundedQuadratic(p.G, p.g, p.lower);
  ASSERT_TRUE(first.solved);
  EXPECT_GT(first.factorizations, 1);
  const auto again = MinimizeBoundedQuadratic(p.G, p.g, p.lower, first.active);
  EXPECT_EQ(again.factorizations, 1);
  EXPECT_EQ(again.x, first.x);
}

TEST(BoundedQuadratic, LeavesWhatIsHeldAtItsBound) {
  std::mt19937_64 engine(5);
  Problem p = RandomProblem(6, engine);
  p.lower.setConstant(-10.0);
  p.lower[2] = 0.7;
  Eigen::VectorXd upper = Eigen::VectorXd::Constant(6, kInfinity);
  upper[2] = 0.7;
  const auto result = MinimizeBoundedQuadratic(p.G, p.g, p.lower, {}, upper);
  ASSERT_TRUE(result.solved);
  EXPECT_EQ(result.x[2], 0.7);
  Eigen::VectorXd gradient = p.G * result.x - p.g;
  gradient[2] = 0.0;
  EXPECT_LT(gradient.norm(), 1e-12 * p.g.norm());
}

TEST(BoundedQuadratic, SaysSoWhereTheQuadraticIsNotConvex) {
  const Eigen::MatrixXd G = Eigen::Vector2d(1.0, -1.0).asDiagonal();
  EXPECT_FALSE(
      MinimizeBoundedQuadratic(G, Eigen::Vector2d(1.0, 1.0), Eigen::Vector2d(0.0, -kInfinity))
          .solved);
}

}  // namespace
}  // namespace lipoid
