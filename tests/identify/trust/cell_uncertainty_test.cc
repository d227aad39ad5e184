#include "identify/trust/cell_uncertainty.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "identify/joint/joint_drawn.h"
#include "identify/joint/joint_trust.h"
#include "identify/stages/staged_run.h"
#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/battery/prediction_band.h"
#include "model/core/special_values.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/plain_joint.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::Truth;

QuantityTrust Quantity(std::string name, double error, double freedom) {
  QuantityTrust q;
  q.name = std::move(name);
  q.standard_error = error;
  q.degrees_of_freedom = freedom;
  return q;
}

TEST(CellUncertainty, IsTheCovarianceWithTheMiddleDegreesOfFreedom) {
  TrustReport trust;
  trust.quantities = {Quantity("beta", 0.01, 40.0),
                      Quantity("r_s", 0.002, 9.0),
                      Quantity("r_1", 0.003, 12.0),
                      Quantity("c_1", 100.0, 11.0)};
  trust.drawn = {"beta", "r_s", "r_1"};
  trust.drawn_covariance =
      Eigen::Matrix3d{{1e-4, 1e-6, 0.0}, {1e-6, 4e-6, 1e-6}, {0.0, 1e-6, 9e-6}};
  const auto uncertainty = UncertaintyOf(trust, Truth(), true);
  ASSERT_TRUE(uncertainty.found.has_value());
  EXPECT_TRUE(uncertainty.unknown.empty());
  // tau_1 stays where r_1 varies: without it the capacitance would.
  EXPECT_EQ(uncertainty.found->parameters,
            (std::vector<std::string>{"beta", "r_s", "r_1", "tau_1"}));
  EXPECT_EQ(uncertainty.found->covariance,
            (std::vector<std::vector<double>>{
                {1e-4, 1e-6, 0, 0}, {1e-6, 4e-6, 1e-6, 0}, {0, 1e-6, 9e-6, 0}, {0, 0, 0, 0}}));
  EXPECT_EQ(uncertainty.found->degrees_of_freedom, 12.0);
  EXPECT_FALSE(uncertainty.found->soc_follows_alpha);  // alpha is not drawn
}

TEST(CellUncertainty, AlphaOfDischargeTimesKeepsItsOwnInterval) {
  TrustReport trust;
  trust.quantities = {Quantity("alpha", 5.0, 2.0), Quantity("r_s", 0.002, 10.0)};
  trust.drawn = {"r_s"};
  trust.drawn_covariance = Eigen::MatrixXd::Constant(1, 1, 4e-6);
  const auto found = *UncertaintyOf(trust, Truth(), true).found;
  EXPECT_EQ(found.parameters, (std::vector<std::string>{"r_s", "alpha"}));
  EXPECT_EQ(found.degrees_of_freedom, 10.0);
  // Student's quantiles by the tables: 4.30265 of two degrees of freedom, 2.22814 of ten.
  EXPECT_NEAR(std::sqrt(found.covariance[1][1]), 5.0 * 4.30265 / 2.22814, 1e-4);
  EXPECT_EQ(found.covariance[0][1], 0.0);
  EXPECT_TRUE(found.soc_follows_alpha);
}

TEST(CellUncertainty, WhatIsNotKnownIsNamedAndWhatDoesNotVaryIsLeftOut) {
  TrustReport trust;
  trust.quantities = {Quantity("alpha", kInfinity, 0.0),
                      Quantity("r_s", std::nan(""), 10.0),
                      Quantity("tau_1", kInfinity, 10.0)};
  trust.drawn = {"r_s", "tau_1"};
  trust.drawn_covariance = Eigen::Matrix2d::Zero();
  const auto uncertainty = UncertaintyOf(trust, Truth(), true);
  EXPECT_FALSE(uncertainty.found.has_value());
  EXPECT_EQ(uncertainty.unknown, (std::vector<std::string>{"alpha", "tau_1"}));
}

TEST(CellUncertainty, ParametersAreNeitherCapacitancesNorValuesOfTables) {
  std::vector<TrustedQuantity> quantities(5);
  const char* names[] = {"beta", "c_1", "r_s(0.5)", "r_total(0.5)", "tau_1"};
  for (std::size_t k = 0; k < 5; ++k) quantities[k].name = names[k];
  const auto parameters = CellParametersAmong(quantities);
  ASSERT_EQ(parameters.size(), 2U);
  EXPECT_EQ(parameters[0].name, "beta");
  EXPECT_EQ(parameters[1].name, "tau_1");
}

// White noise, and noise that takes half a minute to forget.
void AddNoise(std::vector<LoadedLog>& logs, double white_V, double slow_V, std::uint64_t seed) {
  std::uint32_t stream = 0;
  for (auto& log : logs) {
    NormalNoise normal(seed, stream++);
    Record& record = log.log.record;
    double slow = slow_V * normal();
    for (std::size_t k = 0; k < record.size(); ++k) {
      if (k > 0) {
        const double keep = std::exp(-(record.time_s[k] - record.time_s[k - 1]) / 30.0);
        slow = keep * slow + slow_V * std::sqrt(1.0 - keep * keep) * normal();
      }
      record.voltage_V[k] += slow + white_V * normal();
    }
  }
}

// A load that no log of the campaigns has.
struct Load {
  std::vector<double> time_s;
  std::vector<double> current_A;

  explicit Load(double capacity_A) {
    for (int k = 0; k <= 180; ++k) {
      time_s.push_back(10.0 * k);
      current_A.push_back(capacity_A * (0.5 + 1.2 * ((k / 6) % 3)));
    }
  }
};

// The share of rows whose band holds the true voltage.
double Covered(const Cell& found, const Cell& truth, std::uint64_t seed) {
  constexpr int kCells = 200;
  const Load load(truth.capacity_Ah);
  const auto cells = DrawCells(found, kCells, seed).cells;
  const auto band =
      PredictBand(cells, std::vector<double>(kCells, 1.0), load.time_s, load.current_A);
  const auto is = Predict(truth, load.time_s, load.current_A).voltage_V;
  int within = 0;
  int rows = 0;
  for (std::size_t k = 0; k < is.size(); ++k) {
    if (is[k] < truth.cutoff_V) break;  // beyond what any log has seen
    within += band.voltage_low_V[k] <= is[k] && is[k] <= band.voltage_high_V[k] ? 1 : 0;
    ++rows;
  }
  EXPECT_GT(rows, 90);
  return double(within) / rows;
}

// Campaigns that differ by their noise: the band of a new load holds the truth as often as it says.
// The rows of one campaign are nearly one statement, so that the mean over the seeds has a standard
// deviation of at most sqrt(0.95 . 0.05/20) = 5 %, of which two and a half are allowed for.
TEST(CellUncertainty, TheBandOfAJointCellCoversTheTruth) {
  const Cell truth = Truth();
  const auto clean = test::SyntheticLogs(truth, 10.0);
  constexpr int kSeeds = 20;
  double covered = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    auto logs = clean;
    AddNoise(logs, 0.0002, 0.0004, static_cast<std::uint64_t>(seed));
    JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, test::kPlainJoint);
    result.cell.uncertainty =
        UncertaintyOf(AssessJoint(result), result.cell, SocFollowsAlpha(result)).found;
    ASSERT_TRUE(result.cell.uncertainty.has_value());
    // alpha, beta, r_s, r_1, tau_1 and the nodes of v_oc.
    EXPECT_EQ(result.cell.uncertainty->parameters.size(),
              5U + result.cell.open_circuit_voltage.soc().size());
    EXPECT_TRUE(result.cell.uncertainty->soc_follows_alpha);
    ASSERT_NO_THROW((void)ParseCell(CellToJson(result.cell).dump(), "cell.json"));
    covered += Covered(result.cell, truth, static_cast<std::uint64_t>(seed)) / kSeeds;
  }
  fmt::print("{:.1f} % of the rows within the band\n", 100.0 * covered);
  EXPECT_GE(covered, 0.83);
  EXPECT_LE(covered, 0.999);
}

// v_oc(A) and alpha given: what is left is what the staged intervals count.
TEST(CellUncertainty, TheBandOfAStagedCellCoversTheTruth) {
  const Cell truth = Truth();
  const auto clean = test::SyntheticLogs(truth, 10.0);
  StagedGiven given;
  given.alpha_C = truth.alpha_C();
  given.open_circuit_voltage = truth.open_circuit_voltage;
  constexpr int kSeeds = 20;
  double covered = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    auto logs = clean;
    AddNoise(logs, 0.0002, 0.0004, static_cast<std::uint64_t>(seed));
    StagedResult result = IdentifyStaged(test::CampaignOf(logs), logs, {}, given);
    result.cell.uncertainty = UncertaintyOf(result.trust, result.cell, false).found;
    ASSERT_TRUE(result.cell.uncertainty.has_value());
    EXPECT_EQ(result.cell.uncertainty->parameters,
              (std::vector<std::string>{"beta", "r_s", "r_1", "tau_1"}));
    ASSERT_NO_THROW((void)ParseCell(CellToJson(result.cell).dump(), "cell.json"));
    covered += Covered(result.cell, truth, static_cast<std::uint64_t>(seed)) / kSeeds;
  }
  fmt::print("{:.1f} % of the rows within the band\n", 100.0 * covered);
  EXPECT_GE(covered, 0.83);
  EXPECT_LE(covered, 0.999);
}

}  // namespace
}  // namespace lipoid
