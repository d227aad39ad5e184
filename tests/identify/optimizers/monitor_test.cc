#include "identify/optimizers/monitor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <new>
#include <stdexcept>

#include "tests/identify/optimizers/test_problems.h"

namespace lipoid {
namespace {

using test::CostProblem;
using test::DenseProblem;
using test::Rosenbrock;

TEST(Monitor, TakesFixedParametersOut) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, 0.5, 0.5);
  Monitor monitor(problem, Eigen::Vector2d(7.0, 2.0));
  ASSERT_EQ(monitor.size(), 1);
  EXPECT_EQ(monitor.start()[0], 2.0);
  Eigen::VectorXd gradient;
  // 1/2 (100 (y - x²)² + (1 - x)²) at (0.5, 2), and 100 (y - x²) by y.
  EXPECT_DOUBLE_EQ(monitor.Gradient(monitor.start(), gradient), 0.5 * (306.25 + 0.25));
  ASSERT_EQ(gradient.size(), 1);
  EXPECT_NEAR(gradient[0], 175.0, 1e-10);
  EXPECT_EQ(monitor.Factor(monitor.start()).cols(), 2);
  EXPECT_EQ(problem.questions().points().front(), Eigen::VectorXd(Eigen::Vector2d(0.5, 2.0)));
  EXPECT_EQ(problem.evaluations(), 1);
}

TEST(Monitor, RemembersTheBestPointAndTheLast) {
  const DenseProblem problem = Rosenbrock();
  const Eigen::Vector2d good(1.0, 1.1), bad(-1.0, 3.0), worse(3.0, 0.0);
  Monitor monitor(problem, good);
  Eigen::VectorXd gradient;
  for (const auto& x : {good, bad, good, bad}) monitor.Gradient(x, gradient);
  EXPECT_EQ(problem.evaluations(), 2);
  for (const auto& x : {worse, good, worse}) static_cast<void>(monitor.Cost(x));
  EXPECT_EQ(problem.evaluations(), 3);
  monitor.Gradient(worse, gradient);  // the cost alone is not the gradient
  EXPECT_EQ(problem.evaluations(), 4);
  EXPECT_EQ(monitor.best(), Eigen::VectorXd(good));
}

TEST(Monitor, CountsABatchInOrderWhateverTheThreads) {
  // Costs fall and rise: the improvements say in which order they were taken.
  const CostProblem problem(1, false, [](const auto& x, auto*) { return std::abs(x[0] - 40.0); });
  std::vector<Eigen::VectorXd> points;
  for (int k = 0; k < 100; ++k) points.push_back(Eigen::VectorXd::Constant(1, (37 * k) % 100));
  std::vector<Improvement> first;
  for (const int threads : {1, 2, 0}) {
    Monitor monitor(problem, points[0]);
    const auto costs = monitor.Costs(points, threads);
    for (std::size_t k = 0; k < points.size(); ++k) {
      EXPECT_EQ(costs[k], std::abs(points[k][0] - 40.0));
    }
    const auto summary = monitor.Finish(Termination::kConverged, "done");
    EXPECT_EQ(summary.evaluations, 100);
    EXPECT_EQ(summary.x[0], 40.0);
    if (first.empty()) first = summary.improvements;
    ASSERT_EQ(summary.improvements.size(), first.size());
    for (std::size_t k = 0; k < first.size(); ++k) {
      EXPECT_EQ(summary.improvements[k].evaluations, first[k].evaluations);
      EXPECT_EQ(summary.improvements[k].cost, first[k].cost);
    }
  }
  EXPECT_GT(first.size(), 2U);
}

TEST(Monitor, KeepsWhatTheObjectiveThrows) {
  const CostProblem problem(1, false, [](const auto& x, auto*) -> double {
    if (x[0] < 0.0) throw std::runtime_error("negative");
    if (x[0] > 9.0) throw std::bad_alloc();
    if (x[0] > 8.0) throw 10;
    return x[0];
  });
  Monitor monitor(problem, Eigen::VectorXd::Constant(1, 1.0));
  EXPECT_EQ(monitor.Cost(Eigen::VectorXd::Constant(1, 2.0)), 2.0);
  EXPECT_EQ(monitor.Cost(Eigen::VectorXd::Constant(1, -2.0)), HUGE_VAL);
  EXPECT_EQ(monitor.Cost(Eigen::VectorXd::Constant(1, 8.5)), HUGE_VAL);
  const auto failed = monitor.Finish(Termination::kFailure, "It got lost.");
  EXPECT_EQ(failed.message, "It got lost. The first error was: negative");
  EXPECT_EQ(failed.cost, 2.0);
  EXPECT_FALSE(monitor.must_stop());
  EXPECT_EQ(monitor.Costs({Eigen::VectorXd::Constant(1, 9.5)}, 2)[0], HUGE_VAL);
  EXPECT_TRUE(monitor.must_stop());
  EXPECT_THROW(monitor.Finish(Termination::kConverged, "done"), std::bad_alloc);
}

TEST(Monitor, DoesNotAskForWhatIsNoPoint) {
  const DenseProblem problem = Rosenbrock();
  Monitor monitor(problem, Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(monitor.Cost(Eigen::Vector2d(kNaN, 1.0)), HUGE_VAL);
  EXPECT_EQ(problem.evaluations(), 0);
}

}  // namespace
}  // namespace lipoid
