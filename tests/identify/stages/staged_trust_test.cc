#include "identify/stages/staged_trust.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <string>

#include "identify/logs/load_campaign.h"
#include "identify/stages/staged_run.h"
#include "identify/stages/start_values.h"
#include "model/battery/cell_file.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/paths.h"
#include "tests/support/pulse_record.h"

namespace lipoid {
namespace {

using test::kPulseBeta;
using test::kPulseSeries_Ohm;
using test::kPulseTau_s;
using test::PulseRecord;

constexpr double kBranch_Ohm = 0.03;

void AddNoise(Record& record, double white_V, double slow_V, double time_s, std::uint64_t seed) {
  NormalNoise normal(seed, 0);
  const double kept = std::exp(-1.0 / time_s);
  double state = normal();
  for (double& voltage_V : record.voltage_V) {
    voltage_V += white_V * normal() + slow_V * state;
    state = kept * state + std::sqrt(1.0 - kept * kept) * normal();
  }
}

struct Outcome {
  PulseFitResult fit;
  TrustReport trust;
};
Outcome FitAndAssess(const Record& record, const GivenParameters& knowledge = {}) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  const JointSetup setup{.alpha_C = cell.alpha_C(),
                         .open_circuit_voltage = cell.open_circuit_voltage};
  const VoltageSweep sweep(setup, {{.record = &record}});
  Outcome outcome;
  outcome.fit = FitPulses(sweep, {.data = FindStartValues({&record})}, {}, {}, knowledge);
  outcome.trust = AssessStaged(sweep, outcome.fit, std::nullopt);
  return outcome;
}

const QuantityTrust& Of(const TrustReport& trust, const std::string& name) {
  for (const auto& q : trust.quantities) {
    if (q.name == name) return q;
  }
  throw std::out_of_range(name);
}

// The whole way, nonlinear fit and all: simulated logs, staged fit, intervals.
TEST(StagedTrust, IntervalsCoverTheTruthOfSimulatedPulses) {
  const Record clean = PulseRecord(kBranch_Ohm, 200);
  const std::pair<std::string, double> truth[] = {{"beta", kPulseBeta},
                                                  {"r_s", kPulseSeries_Ohm},
                                                  {"r_1", kBranch_Ohm},
                                                  {"tau_1", kPulseTau_s},
                                                  {"c_1", kPulseTau_s / kBranch_Ohm}};
  // More of them for docs/verdicts.md.
  const char* more = std::getenv("LIPOID_TRUST_SEEDS");
  const std::uint64_t seeds = more != nullptr ? std::stoul(more) : 40;
  for (const double time_s : {30.0, 300.0}) {
    int covered = 0;
    int asked = 0;
    for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
      Record record = clean;
      AddNoise(record, 2e-4, 5e-4, time_s, seed);
      const auto outcome = FitAndAssess(record);
      for (const auto& [name, value] : truth) {
        const auto& q = Of(outcome.trust, name);
        covered += q.low <= value && value <= q.high;
        ++asked;
      }
    }
    // 200 intervals, those of one log alike: one standard deviation of the share is 2 %, so that
    // the claim of 90 to 99 % is tested to 86 % and above; docs/verdicts.md has 500 seeds.
    fmt::print("noise of {} s: {:.1f} % of {} intervals cover the truth\n",
               time_s,
               100.0 * covered / asked,
               asked);
    EXPECT_GE(covered, 0.86 * asked) << time_s << " s";
    EXPECT_LE(covered, 0.995 * asked) << time_s << " s";
  }
}

TEST(StagedTrust, LeavesOutWhatWasGiven) {
  Record record = PulseRecord(kBranch_Ohm);
  AddNoise(record, 2e-4, 0.0, 1.0, 1);
  const auto outcome =
      FitAndAssess(record, {.fixed = {{"beta", kPulseBeta}, {"c_1", kPulseTau_s / kBranch_Ohm}}});
  std::string names;
  for (const auto& q : outcome.trust.quantities) names += q.name + " ";
  EXPECT_EQ(names, "r_s r_1 tau_1 ");
  // tau_1 = r_1 c_1 with c_1 known.
  EXPECT_NEAR(Of(outcome.trust, "tau_1").relative_standard_error,
              Of(outcome.trust, "r_1").relative_standard_error,
              1e-9);
}

// Tables 4.8-4.13 of the thesis: a branch that is not there.
TEST(StagedTrust, NamesTheThesisSituation) {
  Record record = PulseRecord(0.0);
  AddNoise(record, 2e-4, 0.0, 1.0, 5);
  const auto outcome = FitAndAssess(record);
  EXPECT_EQ(Of(outcome.trust, "beta").verdict, Verdict::kIdentified);
  EXPECT_NE(Of(outcome.trust, "tau_1").verdict, Verdict::kIdentified);
  // Whether the noise left it at zero or a little above.
  EXPECT_NE(Of(outcome.trust, "r_1").verdict, Verdict::kIdentified);
  EXPECT_NE(outcome.trust.sentence.find("branch 1 was not found"), std::string::npos)
      << outcome.trust.sentence;
}

TEST(StagedTrust, TakesAlphaFromTheDischargeTimes) {
  Record record = PulseRecord(kBranch_Ohm);
  AddNoise(record, 2e-4, 0.0, 1.0, 1);
  const Cell cell = LoadCell("gifi-600mAh-1");
  const VoltageSweep sweep(
      {.alpha_C = cell.alpha_C(), .open_circuit_voltage = cell.open_circuit_voltage},
      {{.record = &record}});
  const auto fit = FitPulses(sweep, {.data = FindStartValues({&record})});
  DischargeTimesResult times;
  times.alpha_C = 1350.0;
  times.alpha_standard_error_C = 5.0;
  times.degrees_of_freedom = 2;
  const auto trust = AssessStaged(sweep, fit, times);
  const auto& alpha = Of(trust, "alpha");
  EXPECT_EQ(&alpha, &trust.quantities[0]);
  constexpr double kStudent = 4.30265;  // two degrees of freedom, 97.5 %: tables
  EXPECT_NEAR(alpha.high, 1350.0 + 5.0 * kStudent, 1e-3);
  EXPECT_EQ(alpha.verdict, Verdict::kIdentified);
  EXPECT_EQ(trust.covariance.rows(), static_cast<Eigen::Index>(trust.quantities.size()));
  times.degrees_of_freedom = 0;  // as many unknowns as times
  EXPECT_EQ(Of(AssessStaged(sweep, fit, times), "alpha").verdict, Verdict::kWeak);
}

// A real cell, whose branch the staged fit loses: its residual is 12 mV of one slow error, which a
// formula for white noise takes for some thousand independent ones.
TEST(StagedTrust, NamesTheLostBranchOfARealCell) {
  const auto file = test::LabDataPath("nissan_leaf_33ah/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const Campaign campaign = ReadCampaign(file);
  const auto result = IdentifyStaged(campaign, LoadCampaign(campaign));
  EXPECT_EQ(Of(result.trust, "r_1").verdict, Verdict::kAtBound);
  EXPECT_TRUE(Of(result.trust, "tau_1").insensitive);
  EXPECT_EQ(result.trust.sentence.find("branch 1 was not found"), 0U) << result.trust.sentence;
  const auto& r_s = Of(result.trust, "r_s");
  EXPECT_GT(r_s.standard_error, 10.0 * r_s.white_standard_error);
  EXPECT_GT(result.trust.residual_correlation[0].correlation_s, 300.0);
}

}  // namespace
}  // namespace lipoid
