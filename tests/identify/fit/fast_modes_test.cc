#include "identify/fit/fast_modes.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "identify/identification.h"
#include "identify/joint/joint_run.h"
#include "identify/joint/joint_sweep.h"
#include "tests/support/plain_joint.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

// Ten modes leave the next, of 0.57 s, to rows every second, and pulses of 6C.
Cell SlowDiffusion() {
  Cell truth = test::Truth();
  truth.diffusion->beta_per_sqrt_s = 0.12;
  truth.diffusion->terms = 200;
  return truth;
}

constexpr double kRows_s = 1.0;
constexpr int kMany = 100;

StagedOptions Modes(int terms) {
  StagedOptions options;
  options.pulses.terms = terms;
  return options;
}

double QuantityIn(const LinearizedFit& fit, const std::string& name) {
  for (const TrustedQuantity& q : fit.quantities) {
    if (q.name == name) return q.value;
  }
  return std::numeric_limits<double>::quiet_NaN();
}

LinearizedFit At(const JointResult& result) {
  return Linearize(JointObservations(result.logs, result.setup), result.choice.best, {});
}

// The second implementation is the fit itself, with more modes.
TEST(FastModes, AFitFollowsThemAsItIsFittedWithThem) {
  const auto logs = test::SyntheticLogs(SlowDiffusion(), kRows_s);
  const Campaign campaign = test::CampaignOf(logs);
  const JointResult few = IdentifyJoint(campaign, logs, Modes(10), test::kPlainJoint);
  const JointResult many = IdentifyJoint(campaign, logs, Modes(kMany), test::kPlainJoint);
  const LinearizedFit fit = At(few);
  const LinearizedFit better = At(many);
  FollowedMoves moves(fit);
  const PulseQuestion question{.soc = 0.5, .current_A = 0.6};
  const auto add = [&](const JointResult& result, const LinearizedFit& of, FollowedMoves& to) {
    AddFastModes(
        of,
        result.choice.best,
        result.setup,
        result.logs.typical_A,
        question,
        [&](const JointSetup& finer) {
          const JointSolution& best = result.choice.best;
          return JointObservations(result.logs, finer).Rows(best.structure, best.rates, best.x);
        },
        to);
  };
  add(few, fit, moves);
  ASSERT_EQ(moves.size(), 1);
  const Eigen::VectorXd move = moves.OfParameters().col(0);
  for (const TrustedQuantity& q : fit.quantities) {
    const double moved = QuantityIn(better, q.name) - q.value;
    // To first order: what they move is small beside the quantity.
    EXPECT_NEAR(q.combination.dot(move), moved, 0.1 * std::abs(moved) + 1e-5 * q.value) << q.name;
  }
  // There is a move, of r_s by 1.4 in 10,000, and none of a fit that has them.
  EXPECT_GT(std::abs(QuantityIn(better, "r_s") / QuantityIn(fit, "r_s") - 1.0), 1e-4);
  FollowedMoves none(better);
  add(many, better, none);
  EXPECT_EQ(none.size(), 0);
}

// Those of the staged method have no other spread of a model.
TEST(FastModes, AreInTheIntervalsOfEitherMethod) {
  const auto logs = test::SyntheticLogs(SlowDiffusion(), kRows_s);
  const Campaign campaign = test::CampaignOf(logs);
  const auto model_error = [&](IdentifyMethod method, int terms, const std::string& name) {
    const Identification found = Identify(
        campaign, logs, {.method = method, .staged = Modes(terms), .joint = test::kPlainJoint});
    return FindQuantity(found.trust, name)->model_standard_error;
  };
  for (const std::string name : {"beta", "r_s", "r_1", "tau_1"}) {
    EXPECT_GT(model_error(IdentifyMethod::kStaged, 10, name), 0.0) << name;
    EXPECT_EQ(model_error(IdentifyMethod::kStaged, kMany, name), 0.0) << name;
    // Less what the table of v_oc(A) adds.
    EXPECT_GT(model_error(IdentifyMethod::kJoint, 10, name),
              1.1 * model_error(IdentifyMethod::kJoint, kMany, name))
        << name;
  }
}

}  // namespace
}  // namespace lipoid
