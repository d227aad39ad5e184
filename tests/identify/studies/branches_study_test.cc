#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/logs/campaign.h"
#include "identify/studies/study.h"
#include "model/core/errors.h"
#include "tests/identify/studies/study_logs.h"
#include "tests/support/paths.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::KnownCampaign;
using test::NoProgress;
using test::PulseLog;
using test::StudyCell;

StudyResult Study(const std::vector<std::pair<double, double>>& branches) {
  const Cell truth = StudyCell(branches);
  const KnownCampaign known(truth, {PulseLog(truth)});
  return StudyBranches(known.Input(), NoProgress);
}

void ExpectNested(const StudyResult& study) {
  ASSERT_EQ(study.rows.size(), 6U);
  for (std::size_t n = 1; n < study.rows.size(); ++n) {
    EXPECT_EQ(study.rows[n].at("branches"), n);
    // "never larger": not by a bit, because the smaller model is a member of the larger.
    EXPECT_LE(study.rows[n].at("rmse_V"), study.rows[n - 1].at("rmse_V")) << n;
  }
}

TEST(StudyBranches, RecommendsAsManyAsTheCellHas) {
  const std::vector<std::vector<std::pair<double, double>>> cells = {
      {}, {{0.03, 45.0}}, {{0.03, 4.0}, {0.04, 150.0}}};
  for (const auto& branches : cells) {
    const auto study = Study(branches);
    EXPECT_EQ(study.facts.at("recommended_branches"), branches.size());
    for (const auto& row : study.rows) {
      EXPECT_EQ(row.at("recommended"), row.at("branches") == branches.size());
    }
    ExpectNested(study);
  }
}

// What counts is what the fit minimizes: a log of a cell without the branch, of next to no weight, has no
// say.
TEST(StudyBranches, CountsTheWeightsOfTheLogs) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  LoadedLog with = PulseLog(truth);
  with.entry.weight = 1e6;
  LoadedLog without = PulseLog(StudyCell({}), 2);
  without.entry.file = without.log.record.file = "other.csv";
  const KnownCampaign known(truth, {with, without});
  const StudyResult study = StudyBranches(known.Input(), NoProgress);
  EXPECT_EQ(study.facts.at("recommended_branches"), 1);
  EXPECT_NEAR(study.rows[1].at("parameters").at("r_1").get<double>(), 0.03, 1e-3);
}

TEST(StudyBranches, ReachesTheNoiseWithTheBranchesOfTheCell) {
  const auto study = Study({{0.03, 45.0}});
  // 6301 rows: the rms of the noise scatters by 1/sqrt(2 N) = 0.9 %.
  EXPECT_NEAR(study.rows[1].at("rmse_V").get<double>() / test::kStudyNoise_V, 1.0, 4 * 0.009);
  EXPECT_GT(study.rows[0].at("rmse_V").get<double>(), 4.0 * test::kStudyNoise_V);
  EXPECT_NEAR(study.rows[1].at("parameters").at("r_1").get<double>(), 0.03, 1e-3);
  EXPECT_NEAR(study.rows[1].at("parameters").at("tau_1").get<double>(), 45.0, 3.0);
}

TEST(StudyBranches, WhiteResidualsAreWorthTheirRows) {
  const auto study = Study({{0.03, 45.0}});
  EXPECT_EQ(study.facts.at("data_rows"), 6301);
  EXPECT_GT(study.facts.at("effective_rows").get<double>(), 0.7 * 6301);
}

TEST(StudyBranches, ResidualsOfAWrongCurveAreWorthFewRowsAndVoteForFewBranches) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign known(truth, {PulseLog(truth)});
  std::vector<double> voltage_V = truth.open_circuit_voltage.voltage_V();
  voltage_V[8] += 0.02;  // a bend that no branch can follow
  known.given.open_circuit_voltage =
      OpenCircuitVoltage::Linear(truth.open_circuit_voltage.soc(), voltage_V);
  const auto study = StudyBranches(known.Input(), NoProgress);
  EXPECT_LT(study.facts.at("effective_rows").get<double>(), 0.05 * 6301);
  EXPECT_LE(study.facts.at("recommended_branches").get<int>(), 1);
  ExpectNested(study);
}

TEST(StudyBranches, TheCriterionIsWhatItsFormulaSays) {
  const auto study = Study({{0.03, 45.0}});
  const double effective = study.facts.at("effective_rows").get<double>();
  const auto value = [&](std::size_t n) {
    const auto& row = study.rows[n];
    return effective * 2.0 * std::log(row.at("rmse_V").get<double>()) +
           row.at("free_parameters").get<double>() * std::log(effective);
  };
  for (std::size_t n = 0; n < 6; ++n) {
    EXPECT_EQ(study.rows[n].at("free_parameters"), 2 + 2 * n);
    const double found = study.rows[n].at("information_criterion").get<double>();
    EXPECT_NEAR(found, value(n) - value(1), 1e-9 * std::abs(value(n)));  // rounding of the logs
  }
}

TEST(StudyBranches, WithoutDiffusionAParameterLess) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign known(truth, {PulseLog(truth)});
  known.options.pulses.diffusion = false;
  const auto study = StudyBranches(known.Input(), NoProgress);
  EXPECT_EQ(study.rows[2].at("free_parameters"), 5);
  EXPECT_FALSE(study.rows[2].at("parameters").contains("beta"));
  ExpectNested(study);
}

// The reference implementation found one minimum without a branch on one cell, and none beyond the
// first that would matter on the other.
TEST(StudyBranches, IsNestedOnRealLogs) {
  for (const char* cell : {"nissan_leaf_33ah", "dmegc_inr18650_26_r1"}) {
    const auto file = test::LabDataPath(std::string(cell) + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    const Campaign campaign = ReadCampaign(file);
    const auto logs = LoadCampaign(campaign);
    const auto study =
        StudyBranches({.campaign = campaign, .logs = logs, .options = {}, .given = {}}, NoProgress);
    SCOPED_TRACE(cell);
    ExpectNested(study);
    EXPECT_LE(study.facts.at("recommended_branches").get<int>(), 1);
  }
}

TEST(StudyBranches, NamesTheFitsThatDidNotConverge) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign known(truth, {PulseLog(truth)});
  EXPECT_EQ(StudyBranches(known.Input(), NoProgress).facts.at("converged"), true);
  known.options.solver.max_iterations = 1;
  const StudyResult study = StudyBranches(known.Input(), NoProgress);
  EXPECT_EQ(study.facts.at("converged"), false);
  bool named = false;
  for (const auto& remark : study.remarks) named = named || remark.starts_with("not converged: ");
  EXPECT_TRUE(named);
  EXPECT_EQ(study.rows[1].at("termination"), "max-iterations");
}

// The number of branches is what is studied.
TEST(StudyBranches, RefusesANumberOfBranches) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign known(truth, {PulseLog(truth)});
  known.options.pulses.branches = 2;
  EXPECT_EQ(
      test::MessageOf<OptionError>([&] { (void)StudyBranches(known.Input(), NoProgress); }),
      "option --branches: this study fits 0 to 5 branches, one after the other; leave it out");
}

TEST(StudyBranches, RefusesToHoldABranchThatNotEveryFitHas) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign known(truth, {PulseLog(truth)});
  known.given.parameters.fixed["r_1"] = 0.03;
  EXPECT_NE(test::MessageOf<OptionError>([&] {
              (void)StudyBranches(known.Input(), NoProgress);
            }).find("no branch is in all of them; say beta or r_s"),
            std::string::npos);
}

}  // namespace
}  // namespace lipoid
