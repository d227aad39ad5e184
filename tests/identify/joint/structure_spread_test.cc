#include "identify/joint/structure_spread.h"

#include <gtest/gtest.h>

#include <cmath>

namespace lipoid {
namespace {

constexpr double kTypical_A = 2.0;
constexpr double kRoundingOfValues = 1e-15;

// Resistances in ohms at the nodes, r_s first; no voltages.
JointSolution Solution(std::vector<double> soc,
                       std::vector<double> tau_s,
                       std::vector<double> ohms,
                       double beta) {
  JointSolution solution;
  solution.structure.branches = static_cast<int>(tau_s.size());
  solution.structure.resistance_soc = std::move(soc);
  solution.rates.beta_per_sqrt_s = beta;
  solution.rates.time_constant_s = std::move(tau_s);
  solution.x =
      Eigen::Map<Eigen::VectorXd>(ohms.data(), static_cast<Eigen::Index>(ohms.size())) * kTypical_A;
  return solution;
}

TEST(StructureSpread, ReadsQuantitiesByTheirNames) {
  // Named branches keep their order, though the second is the faster one.
  const JointSolution constant = Solution({0.5}, {80.0, 20.0}, {0.1, 0.03, 0.05}, 0.2);
  EXPECT_EQ(ValueIn(constant, "beta", kTypical_A, constant), 0.2);
  EXPECT_EQ(ValueIn(constant, "tau_1", kTypical_A, constant), 80.0);
  EXPECT_EQ(ValueIn(constant, "tau_2", kTypical_A, constant), 20.0);
  EXPECT_NEAR(ValueIn(constant, "r_1", kTypical_A, constant), 0.03, kRoundingOfValues);
  EXPECT_NEAR(ValueIn(constant, "r_s(0.2)", kTypical_A, constant), 0.1, kRoundingOfValues);
  EXPECT_NEAR(ValueIn(constant, "c_1", kTypical_A, constant), 80.0 / 0.03, 1e-11);
  EXPECT_NEAR(ValueIn(constant, "r_total(0.5)", kTypical_A, constant), 0.18, kRoundingOfValues);
  for (const char* name : {"tau_3", "r_3", "r_ct", "rho_h", "tau_h", "i_0", "alpha"})
    EXPECT_TRUE(std::isnan(ValueIn(constant, name, kTypical_A, constant))) << name;

  const JointSolution table =
      Solution({0.0, 0.4, 1.0}, {20.0}, {0.3, 0.1, 0.04, 0.2, 0.1, 0.1}, 0.2);
  EXPECT_NEAR(ValueIn(table, "r_s(0.2)", kTypical_A, table), 0.2, kRoundingOfValues);
  EXPECT_NEAR(ValueIn(table, "r_s(0.5)", kTypical_A, table), 0.09, kRoundingOfValues);
  EXPECT_NEAR(
      ValueIn(table, "r_s", kTypical_A, table), (0.2 + 0.09 + 0.06) / 3.0, kRoundingOfValues);
}

// Weights 3/4 and 1/4, betas 0.2 (taken) and 0.24, and halved tables that say 0.21:
// 0.25 * 0.04² + 0.01².
TEST(StructureSpread, IsTheWeightedSquareAndThatOfHalvedTables) {
  JointChoice choice;
  choice.best = Solution({0.5}, {20.0}, {0.1, 0.05}, 0.2);
  choice.tried.push_back({.what = "taken", .solution = choice.best, .weight = 0.75, .taken = true});
  choice.tried.push_back({.what = "another",
                          .solution = Solution({0.5}, {20.0, 90.0}, {0.1, 0.05, 0.01}, 0.24),
                          .weight = 0.25});
  const auto beta = [&](const JointSolution& s) {
    return ValueIn(s, "beta", kTypical_A, choice.best);
  };
  EXPECT_NEAR(SpreadOverStructures(choice, beta).squaredNorm(), 0.25 * 0.04 * 0.04, 1e-15);
  choice.finer = Solution({0.5}, {20.0}, {0.1, 0.05}, 0.21);
  EXPECT_NEAR(
      SpreadOverStructures(choice, beta).squaredNorm(), 0.25 * 0.04 * 0.04 + 0.01 * 0.01, 1e-15);
  // A second branch, far faster than the one taken, is not what the first is compared with.
  choice.finer = Solution({0.5}, {0.0022, 22.0}, {0.1, 0.002, 0.05}, 0.21);
  EXPECT_NEAR(ValueIn(choice.finer, "tau_1", kTypical_A, choice.best), 22.0, 0.2);
  EXPECT_NEAR(ValueIn(choice.finer, "r_1", kTypical_A, choice.best), 0.05, 5e-5);
  // One that was split in two is one: 2 sqrt(tau_a tau_b)/(tau_a + tau_b) of the second half counts.
  const JointSolution split = Solution({0.5}, {15.0, 24.0}, {0.1, 0.02, 0.03}, 0.2);
  const double shared = 2.0 * std::sqrt(15.0 * 24.0) / 39.0;
  EXPECT_NEAR(
      ValueIn(split, "r_1", kTypical_A, choice.best), 0.02 * shared + 0.03, kRoundingOfValues);
  const double log_tau =
      (0.02 * shared * std::log(15.0) + 0.03 * std::log(24.0)) / (0.02 * shared + 0.03);
  EXPECT_NEAR(ValueIn(split, "tau_1", kTypical_A, choice.best), std::exp(log_tau), 1e-13);
  EXPECT_NEAR(ValueIn(split, "c_1", kTypical_A, choice.best),
              std::exp(log_tau) / (0.02 * shared + 0.03),
              1e-10);
  // Where both halves were taken each stands for itself.
  EXPECT_EQ(ValueIn(split, "tau_2", kTypical_A, split), 24.0);
  EXPECT_NEAR(ValueIn(split, "r_2", kTypical_A, split), 0.03, kRoundingOfValues);
  // A quantity that only the other structure has adds nothing.
  const auto i_0 = [&](const JointSolution& s) {
    return ValueIn(s, "i_0", kTypical_A, choice.best);
  };
  EXPECT_TRUE(SpreadOverStructures(choice, i_0).isZero(0.0));
}

// Cells are drawn with the resistances of all branches: each branch of another structure stands for one, and their
// sum is that of the structure. By the nearest alone one branch of 0.05 Ohm would be two.
TEST(StructureSpread, OfDrawnCellsKeepsTheSumOfResistances) {
  const JointSolution taken = Solution({0.5}, {21.0, 46.0}, {0.1, 0.001, 0.03}, 0.2);
  const JointSolution one = Solution({0.5}, {44.0}, {0.1, 0.031}, 0.2);
  const JointSolution three = Solution({0.5}, {10.0, 15.0, 50.0}, {0.1, 0.002, 0.003, 0.03}, 0.2);
  const JointSolution none = Solution({0.5}, {}, {0.12}, 0.2);
  const auto in = [&](const JointSolution& s, const char* name) {
    return ValueIn(s, name, kTypical_A, taken, {}, BranchMatch::kEachOnce);
  };
  EXPECT_EQ(in(one, "r_1"), 0.0);
  EXPECT_TRUE(std::isnan(in(one, "tau_1")));
  EXPECT_NEAR(in(one, "r_2"), 0.031, kRoundingOfValues);
  EXPECT_EQ(in(one, "tau_2"), 44.0);
  EXPECT_NEAR(in(three, "r_1"), 0.005, kRoundingOfValues);
  EXPECT_NEAR(in(three, "r_2"), 0.03, kRoundingOfValues);
  EXPECT_EQ(in(none, "r_1"), 0.0);
  EXPECT_EQ(in(none, "r_2"), 0.0);
  EXPECT_NEAR(ValueIn(one, "r_1", kTypical_A, taken), 0.031, kRoundingOfValues);
}

}  // namespace
}  // namespace lipoid
