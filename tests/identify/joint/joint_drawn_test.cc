#include "identify/joint/joint_drawn.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/joint/joint_trust.h"
#include "identify/logs/campaign.h"
#include "identify/synthesis/synthesize.h"
#include "identify/trust/cell_uncertainty.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "tests/support/paths.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

JointResult WithTables(double initial_soc = 1.0, const StagedGiven& given = {}) {
  Cell truth = LoadCell("gifi-600mAh-1");
  truth.branches = {{Resistance<double>(0.03), 45.0, 1500.0}};
  auto logs = test::SyntheticLogs(truth, 10.0, 0.0003);
  logs[0].entry.initial_soc = initial_soc;
  return IdentifyJoint(test::CampaignOf(logs),
                       logs,
                       {},
                       {.branches = 2,
                        .resistance_nodes = 6,
                        .self_heating = Presence::kOn,
                        .charge_transfer = Presence::kOn,
                        .smoothness = 1e-3},
                       given);
}

// The unknowns with rises for the nodes of v_oc, behind so many rates.
Eigen::VectorXd Unknowns(const JointResult& result, Eigen::Index rates) {
  const JointLayout layout(result.choice.best.structure);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(rates + layout.size());
  x.tail(layout.size()) = result.choice.best.x;
  for (Eigen::Index k = layout.voltages() - 1; k > 0; --k) x[rates + k] -= x[rates + k - 1];
  return x;
}

// Of logs for which two branches are nearly as likely as one the cell file keeps what is known of their sum: a
// branch of the one structure stood for both of the other, and the error of the sum was a hundred times as large.
TEST(JointDrawn, KeepsTheSumOfResistances) {
  const auto folder = test::FreshFolder("joint_drawn.sum");
  RunRecord run;
  run.seed = 205;
  Synthesize(
      test::Truth(), kProtocols[0], {.sampling_s = 2.0, .voltage_noise_V = 0.001}, run, folder);
  const auto logs = LoadCampaign(ReadCampaign(folder + "/campaign.toml"));
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  const auto& tried = result.choice.tried;
  ASSERT_TRUE(std::any_of(tried.begin(), tried.end(), [&](const TriedStructure& row) {
    return row.solution.structure.branches != result.choice.best.structure.branches &&
           row.weight > 0.2;
  }));
  const TrustReport trust = AssessJoint(result);
  const auto of = UncertaintyOf(trust, result.cell, SocFollowsAlpha(result)).found;
  ASSERT_TRUE(of.has_value());
  double variance = 0.0;
  for (std::size_t i = 0; i < of->parameters.size(); ++i) {
    for (std::size_t j = 0; j < of->parameters.size(); ++j) {
      if (of->parameters[i].starts_with("r_") && of->parameters[j].starts_with("r_"))
        variance += of->covariance[i][j];
    }
  }
  const auto total = std::find_if(trust.quantities.begin(),
                                  trust.quantities.end(),
                                  [](const QuantityTrust& q) { return q.name == "r_total(0.5)"; });
  ASSERT_NE(total, trust.quantities.end());
  // Taken apart by structures of other rates and tables, not quite the same.
  EXPECT_LT(std::sqrt(variance), 2.0 * total->standard_error);
}

// Every linear parameter of the cell is its combination of the unknowns, v_oc beside its reference:
// the nodes are those that the cell kept, in its order.
TEST(JointDrawn, CombinationsGiveTheParametersOfTheCell) {
  const JointResult result = WithTables();
  constexpr Eigen::Index kRates = 5;
  const auto drawn = DrawnOfJoint(result, {}, kRates);
  const Eigen::VectorXd x = Unknowns(result, kRates);
  std::vector<std::string> names;
  for (const auto& [name, combination, spread] : drawn) {
    names.push_back(name);
    const auto value = CellParameter(result.cell, name);
    ASSERT_TRUE(value.has_value()) << name;
    double found = combination.dot(x);
    if (name.starts_with("v_oc")) {
      const auto k = static_cast<std::size_t>(std::stoi(name.substr(5)));
      const double soc = result.cell.open_circuit_voltage.soc()[k];
      found += result.setup.open_circuit_voltage(1.0 - (1.0 - soc) * result.alpha_C /
                                                           result.setup.alpha_C);
    }
    EXPECT_NEAR(found, *value, 1e-9) << name;  // sums of volts, and an axis that was moved and back
  }
  std::vector<std::string> nodes;
  for (const char* table : {"r_s", "r_1", "r_2", "r_ct", "dv_dT", "M", "v_oc"}) {
    const auto name = [&](int k) { return fmt::format("{}[{}]", table, k); };
    for (int k = 0; CellParameter(result.cell, name(k)); ++k) nodes.push_back(name(k));
  }
  EXPECT_EQ(names, nodes);
}

TEST(JointDrawn, TheWholeUncertaintyIsOneThatAFileHolds) {
  JointResult result = WithTables();
  const TrustReport trust = AssessJoint(result);
  const auto uncertainty = UncertaintyOf(trust, result.cell, SocFollowsAlpha(result));
  ASSERT_TRUE(uncertainty.found.has_value());
  result.cell.uncertainty = uncertainty.found;
  EXPECT_NO_THROW((void)ParseCell(CellToJson(result.cell).dump(), "cell.json"));
  // What is reported of a parameter is what is drawn.
  for (const QuantityTrust& q : trust.quantities) {
    const auto& names = uncertainty.found->parameters;
    const auto at = std::find(names.begin(), names.end(), q.name);
    if (at == names.end() || !std::isfinite(q.standard_error)) continue;
    const auto k = static_cast<std::size_t>(at - names.begin());
    EXPECT_NEAR(std::sqrt(uncertainty.found->covariance[k][k]) / q.standard_error, 1.0, 1e-4)
        << q.name;
  }
}

// A structure of weight 1/4 that has a milliohm more in r_s and as much less in r_1 moves both so,
// at every node, and nothing else: its square counts, and their sum stays as well known as it was.
TEST(JointDrawn, WhatAnotherStructureMovesTogetherVariesTogether) {
  JointResult result = WithTables();
  const TrustReport before = AssessJoint(result);
  JointSolution other = result.choice.best;
  const JointLayout layout(other.structure);
  const double more = 1e-3 * result.logs.typical_A;
  other.x.segment(layout.series(), layout.nodes()).array() += more;
  other.x.segment(layout.branch(0), layout.nodes()).array() -= more;
  result.choice.tried.push_back({.what = "another", .solution = other, .weight = 0.25});
  const TrustReport after = AssessJoint(result);
  ASSERT_EQ(after.drawn, before.drawn);
  const auto moved = [](const std::string& name) {
    return name.starts_with("r_s[") ? 1e-3 : name.starts_with("r_1[") ? -1e-3 : 0.0;
  };
  for (Eigen::Index i = 0; i < before.drawn_covariance.rows(); ++i) {
    for (Eigen::Index j = 0; j < before.drawn_covariance.rows(); ++j) {
      const std::string& one = after.drawn[static_cast<std::size_t>(i)];
      const std::string& two = after.drawn[static_cast<std::size_t>(j)];
      const double is = before.drawn_covariance(i, j);
      const bool vary = before.drawn_covariance(i, i) > 0.0 && before.drawn_covariance(j, j) > 0.0;
      const double added = vary ? 0.25 * moved(one) * moved(two) : 0.0;
      EXPECT_NEAR(after.drawn_covariance(i, j) - is, added, 1e-12 * (1.0 + std::abs(is)))
          << one << " " << two;
    }
  }
  for (const QuantityTrust& q : after.quantities) {
    if (q.name == "r_s(0.5)") {
      EXPECT_GT(q.model_standard_error, 0.5e-3 * (1.0 - 1e-9));
    }
  }
}

// A convention where every log starts full, an unknown like others where it was fitted, and neither
// where it was given.
TEST(JointDrawn, AlphaTakesPartUnlessItWasGiven) {
  EXPECT_TRUE(SocFollowsAlpha(WithTables()));
  const JointResult fitted = WithTables(0.99);
  EXPECT_EQ(SocFollowsAlpha(fitted), fitted.alpha_source == "least-squares");
  StagedGiven given;
  given.alpha_C = 1353.6;
  const JointResult half_full = WithTables(0.99, given);
  EXPECT_FALSE(SocFollowsAlpha(half_full));
  TrustedQuantity alpha;
  alpha.name = "alpha";
  alpha.combination =
      Eigen::VectorXd::Zero(5 + JointLayout(half_full.choice.best.structure).size());
  for (const auto& one : DrawnOfJoint(half_full, {alpha}, 5)) EXPECT_NE(one.name, "alpha");
}

}  // namespace
}  // namespace lipoid
