// Every row of the table of optimizers passes this one suite.

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <new>
#include <ostream>
#include <stdexcept>
#include <string>

#include "identify/optimizers/optimizers.h"
#include "model/core/errors.h"
#include "tests/identify/optimizers/test_problems.h"

namespace lipoid {

void PrintTo(const OptimizerEntry& entry, std::ostream* out) { *out << entry.name; }

namespace {

using test::CostProblem;
using test::DenseProblem;
using test::LinearProblem;
using test::Rosenbrock;

// How near to the answer an optimizer with its default options must come.
struct Tolerance {
  double quadratic_x = 0.0;   // of a convex quadratic, x of order one
  double rosenbrock_x = 0.0;  // along the bottom of the valley, where the cost is flat
};

const Tolerance& ToleranceOf(std::string_view name) {
  // Gradient methods stop at steps of 1e-6 or a relative change of the cost of 1e-12, whose root is
  // 1e-6: ten times that, and a hundred along the valley. Simplex and trust region stop at a size
  // of 1e-6, but all around the answer. Global methods stop when 20 iterations or more gain less
  // than 1e-6 of a cost of 1/2, whose root is 1e-3, and coordinate-wise steps crawl along the
  // valley.
  static const std::map<std::string_view, Tolerance> all = {
      {"interior-point", {.quadratic_x = 1e-5, .rosenbrock_x = 1e-4}},
      {"sqp", {.quadratic_x = 1e-5, .rosenbrock_x = 1e-4}},
      {"active-set", {.quadratic_x = 1e-5, .rosenbrock_x = 1e-4}},
      {"levenberg-marquardt", {.quadratic_x = 1e-5, .rosenbrock_x = 1e-4}},
      {"genetic", {.quadratic_x = 2e-3, .rosenbrock_x = 1e-2}},
      {"particle-swarm", {.quadratic_x = 2e-3, .rosenbrock_x = 1e-4}},
      {"simulated-annealing", {.quadratic_x = 2e-3, .rosenbrock_x = 1e-2}},
      {"cma-es", {.quadratic_x = 2e-3, .rosenbrock_x = 1e-4}},
      {"differential-evolution", {.quadratic_x = 2e-3, .rosenbrock_x = 1e-4}},
      {"nelder-mead", {.quadratic_x = 1e-5, .rosenbrock_x = 1e-4}},
      {"bobyqa", {.quadratic_x = 1e-5, .rosenbrock_x = 1e-4}},
  };
  return all.at(name);
}

class OptimizerConformance : public testing::TestWithParam<OptimizerEntry> {
 protected:
  [[nodiscard]] static const OptimizerEntry& entry() { return GetParam(); }
  [[nodiscard]] static const Tolerance& tolerance() { return ToleranceOf(entry().name); }
  [[nodiscard]] static OptimizationSummary Minimize(const OptimizationProblem& problem,
                                                    const Eigen::VectorXd& start,
                                                    const OptimizerSettings& settings = {}) {
    return entry().Minimize(problem, start, settings);
  }
};

// What holds of every run, whatever it found.
template <class Problem>
void ExpectHonest(const OptimizationSummary& fit, const Problem& problem) {
  EXPECT_FALSE(problem.outside());
  EXPECT_EQ(fit.evaluations, problem.evaluations());
  EXPECT_EQ(fit.gradient_evaluations, problem.gradient_evaluations());
  EXPECT_FALSE(fit.message.empty());
  EXPECT_GE(fit.wall_s, 0.0);
  ASSERT_EQ(fit.x.size(), problem.size());
  ASSERT_FALSE(fit.improvements.empty());
  EXPECT_EQ(fit.improvements.back().cost, fit.cost);
  for (std::size_t k = 1; k < fit.improvements.size(); ++k) {
    EXPECT_LT(fit.improvements[k].cost, fit.improvements[k - 1].cost);
    EXPECT_GT(fit.improvements[k].evaluations, fit.improvements[k - 1].evaluations);
  }
  // The cost belongs to x, but for the rounding of a norm with and without its Jacobian.
  EXPECT_NEAR(problem.Cost(fit.x), fit.cost, 1e-13 * fit.cost + 1e-300);
}

// 1/2 |A x - b|² of full rank with the minimum at `solution`, where it is 1/2.
DenseProblem Quadratic(const Eigen::VectorXd& solution, double low, double high) {
  const Eigen::Index n = solution.size();
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n + 1, n);
  a.topRows(n) = Eigen::MatrixXd::Constant(n, n, 0.2);
  for (Eigen::Index k = 0; k < n; ++k) a(k, k) += 1.0 + 0.5 * static_cast<double>(k);
  Eigen::VectorXd b = a * solution;
  b[n] = 1.0;
  DenseProblem problem = LinearProblem(a, b);
  for (int k = 0; k < n; ++k) problem.Bound(k, low, high);
  return problem;
}

TEST_P(OptimizerConformance, FindsTheMinimumOfAQuadratic) {
  const Eigen::Vector3d solution(0.4, -0.7, 1.1);
  const DenseProblem problem = Quadratic(solution, -3.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector3d(2.0, 1.0, -1.5));
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_NE(fit.termination, Termination::kMaxIterations) << fit.message;
  EXPECT_LT((fit.x - solution).norm(), tolerance().quadratic_x) << fit.x.transpose();
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, FollowsTheValleyOfRosenbrock) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(-1.2, 1.0));
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_LT((fit.x - Eigen::Vector2d(1.0, 1.0)).norm(), tolerance().rosenbrock_x)
      << fit.x.transpose() << "; " << fit.message << " after " << fit.evaluations;
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, FindsASolutionOnABound) {
  // The free minimum is at (0.4, 2); beyond x2 = 1 the rest of the quadratic decides.
  DenseProblem problem = LinearProblem((Eigen::Matrix2d() << 1.0, 0.5, 0.0, 1.0).finished(),
                                       Eigen::Vector2d(1.4, 2.0));
  problem.Bound(0, -2.0, 2.0).Bound(1, -2.0, 1.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(-1.0, 0.0));
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_NEAR(fit.x[0], 0.9, tolerance().quadratic_x);
  EXPECT_NEAR(fit.x[1], 1.0, tolerance().quadratic_x);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, LeavesABoundAtWhichItStarted) {
  const Eigen::Vector2d solution(0.4, -0.7);
  const DenseProblem problem = Quadratic(solution, -3.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(-3.0, 3.0));
  EXPECT_LT((fit.x - solution).norm(), tolerance().quadratic_x) << fit.x.transpose();
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, PutsAStartFromOutsideOntoTheBounds) {
  const Eigen::Vector2d solution(0.4, -0.7);
  const DenseProblem problem = Quadratic(solution, -3.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(-300.0, 70.0));
  EXPECT_LT((fit.x - solution).norm(), tolerance().quadratic_x) << fit.x.transpose();
  EXPECT_EQ(problem.questions().points().front(), Eigen::Vector2d(-3.0, 3.0));
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, LeavesAParameterWithEqualBoundsAlone) {
  DenseProblem problem = LinearProblem((Eigen::Matrix2d() << 1.0, 0.5, 0.0, 1.0).finished(),
                                       Eigen::Vector2d(1.4, 2.0));
  problem.Bound(0, -2.0, 2.0).Bound(1, 0.6, 0.6);
  const auto fit = Minimize(problem, Eigen::Vector2d(-1.0, 5.0));
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_NEAR(fit.x[0], 1.1, tolerance().quadratic_x);
  EXPECT_EQ(fit.x[1], 0.6);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, HasNothingToDoWhereEveryParameterIsFixed) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, 0.5, 0.5).Bound(1, 0.0, 0.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(0.0, 0.0));
  EXPECT_EQ(fit.termination, Termination::kConverged) << fit.message;
  EXPECT_NEAR(fit.cost, 0.5 * (2.5 * 2.5 + 0.25), 1e-12);
  EXPECT_EQ(fit.evaluations, 1);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, SolvesAProblemOfOneParameter) {
  const DenseProblem problem = Quadratic(Eigen::VectorXd::Constant(1, 0.3), -1.0, 2.0);
  const auto fit = Minimize(problem, Eigen::VectorXd::Constant(1, 1.7));
  EXPECT_NEAR(fit.x[0], 0.3, tolerance().quadratic_x);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, TurnsAwayFromWhereTheCostIsNaN) {
  // sqrt(x) has no value for x < 0; the minimum is at (0.01, 0.5), next to the edge.
  DenseProblem problem(2, [](const auto& x, auto& r, auto* j) {
    r = Eigen::Vector2d(std::sqrt(x[0]) - 0.1, x[1] - 0.5);
    if (j != nullptr) *j = Eigen::Vector2d(0.5 / std::sqrt(x[0]), 1.0).asDiagonal();
  });
  problem.Bound(0, -4.0, 4.0).Bound(1, -1.0, 1.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(3.0, -0.5));
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_NEAR(fit.x[0], 0.01, 0.1 * tolerance().rosenbrock_x + 1e-4);
  EXPECT_NEAR(fit.x[1], 0.5, tolerance().rosenbrock_x);
  EXPECT_FALSE(problem.outside());
  EXPECT_EQ(fit.evaluations, problem.evaluations());
}

TEST_P(OptimizerConformance, SurvivesAnObjectiveThatThrows) {
  DenseProblem problem(2, [](const auto& x, auto& r, auto* j) {
    if (x[0] < 0.0) throw std::runtime_error("no model for negative x");
    r = Eigen::Vector2d(x[0] - 0.5, x[1] - 0.5);
    if (j != nullptr) *j = Eigen::Matrix2d::Identity();
  });
  problem.Bound(0, -4.0, 4.0).Bound(1, -1.0, 1.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(3.0, -0.5));
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_NEAR(fit.x[0], 0.5, tolerance().quadratic_x);
  EXPECT_NEAR(fit.x[1], 0.5, tolerance().quadratic_x);
  EXPECT_EQ(fit.evaluations, problem.evaluations());
}

TEST_P(OptimizerConformance, SaysThatItFailedWhereNothingHasAValue) {
  DenseProblem nan(2, [](const auto&, auto& r, auto* j) {
    r = Eigen::VectorXd::Constant(2, kNaN);
    if (j != nullptr) *j = Eigen::MatrixXd::Constant(2, 2, kNaN);
  });
  DenseProblem throws(
      2, [](const auto&, auto&, auto*) { throw std::runtime_error("the model is not there"); });
  for (DenseProblem* problem : {&nan, &throws}) {
    problem->Bound(0, -1.0, 1.0).Bound(1, -1.0, 1.0);
    const auto fit = Minimize(*problem, Eigen::Vector2d(0.5, 3.0));
    EXPECT_EQ(fit.termination, Termination::kFailure);
    EXPECT_FALSE(fit.usable());
    EXPECT_TRUE(std::isnan(fit.cost)) << fit.cost;
    EXPECT_EQ(fit.x, Eigen::VectorXd(Eigen::Vector2d(0.5, 1.0)));
    EXPECT_NE(fit.message.find("finite value"), std::string::npos) << fit.message;
    EXPECT_EQ(fit.message.find("not there") != std::string::npos, problem == &throws);
    EXPECT_EQ(fit.evaluations, problem->evaluations());
  }
}

TEST_P(OptimizerConformance, LetsGoOfTheLibraryBeforeItSaysThatMemoryRanOut) {
  int calls = 0;
  DenseProblem problem(2, [&calls](const auto& x, auto& r, auto* j) {
    if (++calls > 7) throw std::bad_alloc();
    r = Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
    if (j != nullptr) *j = (Eigen::Matrix2d() << -20.0 * x[0], 10.0, -1.0, 0.0).finished();
  });
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  EXPECT_THROW(static_cast<void>(Minimize(problem, Eigen::Vector2d(-1.2, 1.0))), std::bad_alloc);
  EXPECT_EQ(calls, 8);
}

TEST_P(OptimizerConformance, AnswersWithTheStartWhereNoIterationIsAllowed) {
  OptimizerSettings settings;
  entry().set(settings, "iterations_per_variable", "0");
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(-1.2, 1.0), settings);
  EXPECT_EQ(fit.termination, Termination::kMaxIterations);
  EXPECT_EQ(fit.x, Eigen::VectorXd(Eigen::Vector2d(-1.2, 1.0)));
  EXPECT_EQ(fit.iterations, 0);
  EXPECT_EQ(fit.evaluations, 1);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, KeepsToItsIterations) {
  OptimizerSettings settings;
  entry().set(settings, "iterations_per_variable", "2");
  for (const auto& option : entry().options()) {
    if (option.name.ends_with("_tolerance")) entry().set(settings, option.name, "0");
  }
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(-1.2, 1.0), settings);
  EXPECT_EQ(fit.termination, Termination::kMaxIterations) << fit.message;
  EXPECT_EQ(fit.iterations, 4);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, TakesACostThatIsNoSumOfSquares) {
  const auto cost = [](const Eigen::VectorXd& x, Eigen::VectorXd* gradient) {
    if (gradient != nullptr) {
      *gradient = Eigen::Vector2d(std::sinh(x[0] - 0.3), 2.0 * std::sinh(x[1] + 0.6));
    }
    return std::cosh(x[0] - 0.3) + 2.0 * std::cosh(x[1] + 0.6);
  };
  CostProblem problem(2, entry().needs_gradient, cost);
  problem.Bound(0, -2.0, 2.0);
  problem.Bound(1, -2.0, 2.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(1.5, 1.0));
  if (entry().needs_least_squares) {
    EXPECT_EQ(fit.termination, Termination::kFailure);
    EXPECT_NE(fit.message.find("needs residuals"), std::string::npos) << fit.message;
    EXPECT_EQ(problem.evaluations(), 0);
    return;
  }
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_NEAR(fit.x[0], 0.3, tolerance().quadratic_x);
  EXPECT_NEAR(fit.x[1], -0.6, tolerance().quadratic_x);
  ExpectHonest(fit, problem);
}

TEST_P(OptimizerConformance, AsksForAGradientOnlyWhereItNeedsOne) {
  const DenseProblem problem = Quadratic(Eigen::Vector2d(0.4, -0.7), -3.0, 3.0);
  const auto fit = Minimize(problem, Eigen::Vector2d(2.0, 2.0));
  EXPECT_EQ(fit.gradient_evaluations > 0, entry().needs_gradient);
  const CostProblem without(1, false, [](const auto& x, auto*) { return x[0] * x[0]; });
  if (!entry().needs_gradient) return;
  const auto refused = Minimize(without, Eigen::VectorXd::Constant(1, 0.5));
  EXPECT_EQ(refused.termination, Termination::kFailure);
  EXPECT_FALSE(refused.message.empty());
}

TEST_P(OptimizerConformance, NeedsABoxOnlyWhereItSaysSo) {
  const Eigen::Vector2d solution(0.4, -0.7);
  const DenseProblem problem = Quadratic(solution, -kUnbounded, kUnbounded);
  const auto fit = Minimize(problem, Eigen::Vector2d(2.0, 2.0));
  if (entry().needs_box) {
    EXPECT_EQ(fit.termination, Termination::kFailure);
    EXPECT_NE(fit.message.find("finite bounds"), std::string::npos) << fit.message;
    return;
  }
  EXPECT_TRUE(fit.usable()) << fit.message;
  EXPECT_LT((fit.x - solution).norm(), tolerance().quadratic_x) << fit.x.transpose();
}

TEST_P(OptimizerConformance, GivesTheSameBitsAgain) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  const auto first = Minimize(problem, Eigen::Vector2d(-1.2, 1.0));
  const auto second = Minimize(problem, Eigen::Vector2d(-1.2, 1.0));
  EXPECT_EQ(first.x, second.x);
  EXPECT_EQ(first.cost, second.cost);
  EXPECT_EQ(first.evaluations, second.evaluations);
  EXPECT_EQ(first.iterations, second.iterations);
  EXPECT_EQ(first.message, second.message);
}

TEST_P(OptimizerConformance, GivesTheSameBitsWithTwoThreads) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  OptimizerSettings settings;
  settings.context.seed = 7;
  const auto one = Minimize(problem, Eigen::Vector2d(-1.2, 1.0), settings);
  const auto asked = problem.questions().points();
  settings.context.threads = 2;
  DenseProblem again = Rosenbrock();
  again.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  const auto two = Minimize(again, Eigen::Vector2d(-1.2, 1.0), settings);
  EXPECT_EQ(one.x, two.x);
  EXPECT_EQ(one.cost, two.cost);
  EXPECT_EQ(one.evaluations, two.evaluations);
  EXPECT_EQ(one.iterations, two.iterations);
  ASSERT_EQ(one.improvements.size(), two.improvements.size());
  for (std::size_t k = 0; k < one.improvements.size(); ++k) {
    EXPECT_EQ(one.improvements[k].cost, two.improvements[k].cost);
    EXPECT_EQ(one.improvements[k].evaluations, two.improvements[k].evaluations);
  }
}

TEST_P(OptimizerConformance, AsksTheStartFirstAndFollowsItsSeedOnlyWhereItIsGlobal) {
  const auto run = [](std::uint64_t seed) {
    DenseProblem problem = Rosenbrock();
    problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
    OptimizerSettings settings;
    settings.context.seed = seed;
    static_cast<void>(Minimize(problem, Eigen::Vector2d(-1.2, 1.0), settings));
    return problem.questions().points();
  };
  const auto first = run(1);
  const auto second = run(2);
  EXPECT_EQ(first.front(), Eigen::VectorXd(Eigen::Vector2d(-1.2, 1.0)));
  EXPECT_EQ(second.front(), first.front());
  EXPECT_EQ(first != second, entry().global);
}

TEST_P(OptimizerConformance, PrintsNothing) {
  DenseProblem problem = Rosenbrock();
  problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
  testing::internal::CaptureStderr();
  testing::internal::CaptureStdout();
  static_cast<void>(Minimize(problem, Eigen::Vector2d(-1.2, 1.0)));
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST_P(OptimizerConformance, DocumentsItsOptionsAndRefusesOthers) {
  OptimizerSettings settings;
  const auto options = entry().options();
  const auto values = entry().values(settings);
  ASSERT_EQ(options.size(), values.size());
  for (std::size_t k = 0; k < options.size(); ++k) {
    EXPECT_FALSE(options[k].help.empty()) << options[k].name;
    EXPECT_FALSE(options[k].valid.empty()) << options[k].name;
    EXPECT_EQ(options[k].name, values[k].first);
    EXPECT_EQ(options[k].default_text, values[k].second) << options[k].name;
    EXPECT_THROW(entry().set(settings, options[k].name, "-1e99"), OptionError) << options[k].name;
    EXPECT_THROW(entry().set(settings, options[k].name, "nan"), OptionError) << options[k].name;
  }
  EXPECT_THROW(entry().set(settings, "no_such_option", "1"), OptionError);
  entry().set(settings, "step_tolerance", "0.25");
  EXPECT_EQ(entry().values(settings)[0],
            (std::pair<std::string, std::string>("step_tolerance", "0.25")));
}

// Libraries trust their callers: pagmo's swarm reads beyond its end with more neighbours than
// particles.
TEST_P(OptimizerConformance, SurvivesEveryOptionAtTheEndsOfItsRange) {
  constexpr double kMost = 100.0;  // beyond it only patience would be tested
  for (const auto& option : entry().options()) {
    const auto middle = option.valid.find(" .. ");
    if (middle == std::string::npos) continue;
    for (const auto& value : {option.valid.substr(0, middle), option.valid.substr(middle + 4)}) {
      if (std::stod(value) > kMost) continue;
      SCOPED_TRACE(option.name + "=" + value);
      OptimizerSettings settings;
      entry().set(settings, option.name, value);
      DenseProblem problem = Rosenbrock();
      problem.Bound(0, -2.0, 2.0).Bound(1, -1.0, 3.0);
      const auto fit = Minimize(problem, Eigen::Vector2d(-1.2, 1.0), settings);
      EXPECT_NE(fit.termination, Termination::kNotRun);
      EXPECT_LE(fit.cost, 12.1 + 1e-9);  // that of the start
      ExpectHonest(fit, problem);
    }
  }
}

class GradientConformance : public OptimizerConformance {};

TEST_P(GradientConformance, SolvesProblemsOfNist) {
  OptimizerSettings settings;
  for (const auto& option : entry().options()) {
    if (option.name.ends_with("_tolerance")) entry().set(settings, option.name, "1e-15");
  }
  constexpr double kFourDigits = 1e-4;
  for (const auto& nist : test::NistProblems()) {
    const auto n = static_cast<Eigen::Index>(nist.certified.size());
    for (const auto& from : nist.starts) {
      if (!entry().needs_least_squares && from != nist.starts.back()) continue;  // the nearer one
      const Eigen::VectorXd unit = Eigen::Map<const Eigen::VectorXd>(from.data(), n);
      const DenseProblem natural = test::MakeNistProblem(nist);
      const DenseProblem scaled(static_cast<int>(n), [&](const auto& x, auto& r, auto* j) {
        natural.Rows(x.cwiseProduct(unit), r, j);
        if (j != nullptr) *j = *j * unit.asDiagonal();
      });
      const auto fit = Minimize(scaled, Eigen::VectorXd::Ones(n), settings);
      EXPECT_TRUE(fit.usable()) << nist.name << ": " << fit.message;
      for (Eigen::Index k = 0; k < n; ++k) {
        const double certified = nist.certified[static_cast<std::size_t>(k)];
        EXPECT_NEAR(fit.x[k] * unit[k], certified, kFourDigits * std::abs(certified))
            << nist.name << " b" << k + 1 << " from b1 = " << from[0] << ": " << fit.message
            << " cost " << 2.0 * fit.cost << " of " << nist.certified_sum_of_squares;
      }
    }
  }
}

std::string TestName(const testing::TestParamInfo<OptimizerEntry>& row) {
  std::string name(row.param.name);
  std::replace(name.begin(), name.end(), '-', '_');
  return name;
}

std::vector<OptimizerEntry> WithGradient() {
  std::vector<OptimizerEntry> rows;
  for (const auto& row : Optimizers()) {
    if (row.needs_gradient) rows.push_back(row);
  }
  return rows;
}

INSTANTIATE_TEST_SUITE_P(Table, OptimizerConformance, testing::ValuesIn(Optimizers()), TestName);
INSTANTIATE_TEST_SUITE_P(Table, GradientConformance, testing::ValuesIn(WithGradient()), TestName);

// A step that changes the cost little is no answer where a step down the gradient would change it much.
TEST(OptimizerTable, SaysWhereTheCostStillFalls) {
  const DenseProblem valley = Rosenbrock();
  OptimizerSettings hasty;
  hasty.sqp.function_tolerance = 0.95;
  const auto stopped = FindOptimizer("sqp").Minimize(valley, Eigen::Vector2d(-1.2, 1.0), hasty);
  ASSERT_GT(stopped.cost, 1e-3);
  EXPECT_EQ(stopped.termination, Termination::kStalled);
  EXPECT_NE(stopped.message.find("the cost still falls"), std::string::npos) << stopped.message;
  EXPECT_EQ(FindOptimizer("sqp").Minimize(valley, Eigen::Vector2d(-1.2, 1.0), {}).termination,
            Termination::kConverged);
}

TEST(OptimizerTable, NamesTheElevenInTheOrderOfTheThesis) {
  std::vector<std::string_view> names;
  for (const auto& row : Optimizers()) names.push_back(row.name);
  EXPECT_EQ(names,
            (std::vector<std::string_view>{"interior-point",
                                           "sqp",
                                           "active-set",
                                           "levenberg-marquardt",
                                           "genetic",
                                           "particle-swarm",
                                           "simulated-annealing",
                                           "cma-es",
                                           "differential-evolution",
                                           "nelder-mead",
                                           "bobyqa"}));
  EXPECT_EQ(FindOptimizer("sqp").library, "NLopt");
  EXPECT_THROW(static_cast<void>(FindOptimizer("newton")), OptionError);
}

}  // namespace
}  // namespace lipoid
