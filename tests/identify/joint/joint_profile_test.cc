#include "identify/joint/joint_profile.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "identify/joint/held_shape.h"
#include "identify/joint/joint_trust.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "tests/support/plain_joint.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

std::vector<LoadedLog> Logs() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(0.03), 45.0, 1500.0}};
  return test::SyntheticLogs(cell, 5.0, 0.0005);
}

std::string Refusal(const std::vector<std::string>& names,
                    const JointResult& result,
                    const TrustReport& trust) {
  try {
    (void)ProfileJoint(names, result, trust);
  } catch (const OptionError& error) {
    return error.what();
  }
  return "";
}

// Refits against sensitivities: the model is nearly linear over so short intervals.
TEST(JointProfile, AgreesWithTheStandardErrorWhereTheModelIsNearlyLinear) {
  const auto logs = Logs();
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, test::kPlainJoint);
  const TrustReport trust = AssessJoint(result);
  const auto profiles = ProfileJoint({"beta", "r_s", "r_1", "tau_1"}, result, trust);
  ASSERT_EQ(profiles.size(), 4U);
  for (const Profile& profile : profiles) {
    SCOPED_TRACE(profile.name);
    const QuantityTrust& wald = *FindQuantity(trust, profile.name);
    EXPECT_EQ(profile.unit, wald.unit);
    EXPECT_NEAR(profile.estimate / wald.estimate, 1.0, 1e-12);
    ASSERT_EQ(profile.points.size(), 21U);
    // The run stops where its rates are known to a few hundredths of their errors.
    EXPECT_NEAR((profile.points[10].cost - profile.least_cost) / profile.rise_95, 0.0, 0.01);
    constexpr double kCurvature = 0.15;
    EXPECT_NEAR((wald.estimate - profile.low) / (wald.estimate - wald.low), 1.0, kCurvature);
    EXPECT_NEAR((profile.high - wald.estimate) / (wald.high - wald.estimate), 1.0, kCurvature);
    EXPECT_NEAR(profile.points[10].rmse_V / result.rmse_V, 1.0, 1e-3);
  }
}

// The slope of straight lines between the nodes of v_oc(A) jumps at every node. Taken for information
// these jumps made beta twice as certain, where tables follow all that is smooth.
TEST(JointProfile, WhatIsKnownBesideTablesIsNotTheSawOfTheCurve) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(0.03), 45.0, 1500.0}};
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (int k = 0; k <= 100; ++k) {
    const double a = 0.01 * k;
    soc.push_back(a);
    voltage_V.push_back(3.0 + 0.55 * -std::expm1(-14.0 * a) + 0.42 * std::pow(a, 1.3) +
                        0.2 * a * a * a);
  }
  cell.open_circuit_voltage = OpenCircuitVoltage::MonotoneCubic(soc, voltage_V);
  auto logs = test::SyntheticLogs(cell, 1.0);
  test::AddColouredNoise(logs, 0.0002, 0.0005, 1);
  JointOptions options = test::kPlainJoint;
  options.resistance_nodes = 13;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, options);
  const TrustReport trust = AssessJoint(result);
  const Profile profile = ProfileJoint({"beta"}, result, trust)[0];
  const QuantityTrust& beta = *FindQuantity(trust, "beta");
  // A profile is no parabola; with the jumps the interval was half as long, and the profile had no end in its range.
  EXPECT_NEAR((beta.estimate - profile.low) / (beta.estimate - beta.low), 1.0, 0.35);
  EXPECT_NEAR((profile.high - beta.estimate) / (beta.high - beta.estimate), 1.0, 0.35);
}

TEST(JointProfile, RefusesWhatItCannotHold) {
  const auto logs = Logs();
  JointOptions options = test::kPlainJoint;
  options.resistance_nodes = 6;
  StagedGiven given;
  given.parameters.fixed["beta"] = 0.1924;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, options, given);
  const TrustReport trust = AssessJoint(result);
  const std::vector<Profile> found = ProfileJoint({"r_s", "beta", "tau_2", "tau_1"}, result, trust);
  ASSERT_EQ(found.size(), 4u);
  EXPECT_EQ(found[0].name, "tau_1");
  EXPECT_FALSE(found[0].points.empty());
  EXPECT_EQ(found[0].none_because, "");
  EXPECT_EQ(found[1].name, "r_s");
  EXPECT_EQ(found[1].none_because,
            "it is a table over the state of charge here, and no single value can be held; --set "
            "joint.resistance_nodes=1 makes it one number");
  EXPECT_EQ(found[2].none_because, "it is given, or follows from what is");
  EXPECT_EQ(found[3].none_because, "the structure that was chosen does not have it");
  for (std::size_t k = 1; k < 4; ++k) EXPECT_TRUE(found[k].points.empty());
  EXPECT_NE(Refusal({"c_1"}, result, trust).find("profile tau_1 instead"), std::string::npos);
  EXPECT_NE(Refusal({"alpha"}, result, trust).find("convention"), std::string::npos);
}

// What the structure may become is not known yet: only names that no choice has are refused.
TEST(JointProfile, NamesThatNoRunHasAreRefusedBeforeALogIsRead) {
  const auto refusal = [](const std::vector<std::string>& names,
                          const StagedGiven& given,
                          const JointOptions& options) -> std::string {
    try {
      CheckJointProfile(names, given, options, true);
    } catch (const OptionError& error) {
      return error.what();
    }
    return "";
  };
  const std::vector<std::string> some_run_has{
      "beta", "r_s", "r_1", "tau_3", "tau_h", "i_0", "E", "E_s", "E_2", "gamma"};
  EXPECT_EQ(refusal(some_run_has, {}, {}), "");
  EXPECT_EQ(refusal({"bta"}, {}, test::kPlainJoint),
            "option --profile: no parameter 'bta' in this fit; profiles can be had of beta, r_s, "
            "r_1, tau_1, E_d, E_s, E_1, gamma, E");
  EXPECT_NE(refusal({"tau_4"}, {}, {}), "");
  EXPECT_NE(refusal({"tau_2"}, {}, test::kPlainJoint), "");
  EXPECT_NE(refusal({"tau_h"}, {}, test::kPlainJoint), "");
  StagedGiven given;
  given.parameters.fixed["beta"] = 0.1924;
  EXPECT_NE(refusal({"beta"}, given, {}).find("'beta' is given"), std::string::npos);
  HeldShape held;
  held.cell = LoadCell("gifi-600mAh-1");
  given = {};
  given.reference = std::make_shared<const HeldShape>(held);
  EXPECT_EQ(refusal({"beta", "r_s"}, given, {}), "");
  EXPECT_NE(refusal({"tau_1"}, given, {}).find("'tau_1' is given"), std::string::npos);
}

}  // namespace
}  // namespace lipoid
