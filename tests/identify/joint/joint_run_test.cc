#include "identify/joint/joint_run.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/joint/joint_report.h"
#include "identify/joint/joint_trust.h"
#include "identify/logs/campaign.h"
#include "identify/logs/discharge.h"
#include "identify/stages/open_circuit_voltage_file.h"
#include "identify/synthesis/synthesize.h"
#include "identify/trust/profile.h"
#include "identify/validation.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/paths.h"
#include "tests/support/plain_joint.h"
#include "tests/support/synthetic_campaign.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

constexpr double kSmallNoise_V = 0.0002;

Cell TruthOf(const std::string& name = "gifi-600mAh-1") {
  Cell cell = LoadCell(name);
  const double r = 0.25 * cell.series_resistance_Ohm(0.5);
  cell.branches = {{Resistance<double>(r), 45.0, 45.0 / r}};
  return cell;
}

JointResult Identify(const std::vector<LoadedLog>& logs,
                     const StagedGiven& given = {},
                     const JointOptions& options = {}) {
  return IdentifyJoint(test::CampaignOf(logs), logs, {}, options, given);
}

bool OneSays(const std::vector<std::string>& sentences, const std::string& words) {
  return std::any_of(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
    return sentence.find(words) != std::string::npos;
  });
}

// Every parameter within a percent, rows at the noise: sampled quickly, and as cyclers do.
TEST(JointRun, FindsEveryParameterOfSyntheticCampaigns) {
  for (const char* name : {"gifi-600mAh-1", "gifi-600mAh-3", "grepow-32Ah-2"}) {
    for (const double sampling_s : {1.0, 10.0}) {
      const Cell truth = TruthOf(name);
      const auto logs = test::SyntheticLogs(truth, sampling_s, kSmallNoise_V);
      const JointResult result = IdentifyJoint(test::CampaignOf(logs, truth.capacity_Ah), logs);
      SCOPED_TRACE(std::string(name) + " every " + std::to_string(sampling_s) + " s");
      EXPECT_TRUE(result.converged);
      for (const char* parameter : {"alpha", "beta", "r_s", "r_1", "tau_1", "c_1"}) {
        const auto estimate = CellParameter(result.cell, parameter);
        ASSERT_TRUE(estimate) << parameter;
        const double is = *CellParameter(truth, parameter);
        EXPECT_NEAR(*estimate, is, 0.01 * is) << parameter;
      }
      const auto& pulses = result.fitted.back();
      EXPECT_EQ(pulses.file, "pulses.csv");
      EXPECT_NEAR(pulses.all.rmse, kSmallNoise_V, 0.1 * kSmallNoise_V);
    }
  }
}

// What new logs err more, by the noise that the fit has followed, counts; less than held-out rows say does not.
TEST(JointRun, TheErrorToExpectCountsWhatTheFitHasFollowed) {
  const JointResult result = Identify(test::SyntheticLogs(TruthOf(), 5.0, 0.001));
  const JointObservations seen(result.logs, result.setup);
  TrustReport trust = AssessJoint(result);
  const auto expected = [&](double new_over_fitted) {
    trust.new_over_fitted.assign(result.logs.logs.size(), new_over_fitted);
    return ExpectError(JointFit(seen, {}), result.logs, result.choice.best, trust).percent;
  };
  double own_percent = 0.0;
  for (const LogErrors& log : result.fitted)
    own_percent += log.all.mean_error_percent / static_cast<double>(result.fitted.size());
  EXPECT_NEAR(expected(4.0), 4.0 * own_percent, 0.05 * own_percent);
  EXPECT_EQ(expected(0.5), expected(0.1));
  EXPECT_GT(expected(0.5), own_percent);
}

// A branch faster than two rows would smooth that noise: twenty-four of such campaigns had one each, and
// resistances that were 2.4 % too small.
TEST(JointRun, NoiseOfAnInstrumentIsNoBranch) {
  constexpr double kNoise_A = 0.01;
  const Cell truth = TruthOf();
  auto logs = test::SyntheticLogs(truth, 2.0, 0.001);
  NormalNoise normal(5, 0);
  for (LoadedLog& log : logs) {
    std::vector<double> current_A;
    for (const double flows_A : log.log.record.current_A)
      current_A.push_back(flows_A + kNoise_A * normal());
    log.log.record.current_A = std::move(current_A);
  }
  const JointResult result = Identify(logs);
  EXPECT_TRUE(OneSays(result.cautions, "pulses.csv wavers by 0.01 A")) << result.cautions.back();
  ASSERT_EQ(result.cell.branches.size(), 1U);
  const TrustReport trust = AssessJoint(result);
  for (const char* parameter : {"beta", "r_s", "r_1", "tau_1"}) {
    const double is = *CellParameter(truth, parameter);
    const QuantityTrust* found = FindQuantity(trust, parameter);
    ASSERT_NE(found, nullptr) << parameter;
    EXPECT_LT(std::abs(found->estimate - is), 3.0 * found->standard_error) << parameter;
    EXPECT_LT(found->standard_error, 0.12 * is) << parameter;
  }
  // The charge of the slow log was counted as the noise has it.
  double squares = 0.0;
  const Record& slow = logs[3].log.record;
  for (std::size_t k = 1; k < slow.size(); ++k)
    squares += std::pow(slow.time_s[k] - slow.time_s[k - 1], 2);
  EXPECT_EQ(logs[3].entry.kind, LogKind::kLowRate);
  // The noise is the most of any log, and that of a short one is known to some per cent.
  EXPECT_NEAR(result.counting_C, kNoise_A * std::sqrt(squares), 0.05 * result.counting_C);
  const QuantityTrust* alpha = FindQuantity(trust, "alpha");
  ASSERT_NE(alpha, nullptr);
  EXPECT_GT(alpha->standard_error, result.counting_C);
  EXPECT_LT(std::abs(alpha->estimate - truth.alpha_C()), 3.0 * alpha->standard_error);
}

// A branch of one row: held at two, it would stand in for r_s, and what a pulse drops within a second and within
// 30 s would be off by more than its interval.
TEST(JointRun, FindsABranchThatIsFasterThanTwoRows) {
  Cell truth = TruthOf();
  truth.branches = {{Resistance<double>(0.06), 10.0, {}}};
  const auto logs = test::SyntheticLogs(truth, 10.0, kSmallNoise_V);
  const JointResult result = Identify(logs);
  EXPECT_TRUE(OneSays(result.cautions, "a branch stood at 20 s, twice the time between rows"));
  const TrustReport trust = AssessJoint(result);
  for (const char* parameter : {"r_s", "r_1", "tau_1"}) {
    const QuantityTrust* found = FindQuantity(trust, parameter);
    ASSERT_NE(found, nullptr) << parameter;
    const double is = *CellParameter(truth, parameter);
    // Three standard errors: one campaign in a hundred lies outside.
    EXPECT_LE(std::abs(found->estimate - is), 1.5 * Reach95(*found)) << parameter;
    EXPECT_NEAR(found->estimate, is, 0.05 * is) << parameter;
  }
}

TEST(JointRun, ItsCellIsWhatWasFitted) {
  const auto logs = test::SyntheticLogs(TruthOf(), 5.0, 0.001);
  const JointResult result = Identify(logs);
  // The capacity reference moves alpha and the nodes together: no voltage changes.
  const JointSolution& best = result.choice.best;
  const auto rows =
      JointObservations(result.logs, result.setup).Rows(best.structure, best.rates, best.x);
  for (std::size_t l = 0; l < logs.size(); ++l) {
    if (result.logs.logs[l].size() != logs[l].log.record.size()) continue;  // in few points
    const Record& record = logs[l].log.record;
    const auto predicted = Predict(result.cell, record.time_s, record.current_A);
    for (std::size_t k = 0; k < record.size(); ++k) {
      ASSERT_NEAR(record.voltage_V[k] - predicted.voltage_V[k],
                  rows[l].residual_V[static_cast<Eigen::Index>(k)],
                  1e-11)
          << record.file << " row " << k;
    }
  }
}

TEST(JointRun, AlphaEndsWhereTheCurveReachesTheCutOff) {
  const auto logs = test::SyntheticLogs(TruthOf(), 5.0, kSmallNoise_V);
  const JointResult result = Identify(logs);
  EXPECT_EQ(result.alpha_source, "cut-off");
  EXPECT_NEAR(result.cell.open_circuit_voltage(0.0), 3.0, 1e-9);
  StagedGiven given;
  given.alpha_C = 1400.0;
  const JointResult with_alpha = Identify(logs, given);
  EXPECT_EQ(with_alpha.alpha_C, 1400.0);
  EXPECT_EQ(with_alpha.alpha_source, "given");
  // Another capacity reference of the same cell: only the nodes of v_oc lie elsewhere, off the
  // kinks of the truth.
  EXPECT_LT(with_alpha.rmse_V, 1.5 * result.rmse_V);
  EXPECT_EQ(with_alpha.alpha_doubt, "");
  given.alpha_C = 1200.0;
  const std::string doubt = Identify(logs, given).alpha_doubt;
  EXPECT_NE(doubt.find("alpha is 0.3333 Ah, and "), std::string::npos) << doubt;
  EXPECT_NE(doubt.find("out of a full cell above the cut-off"), std::string::npos) << doubt;
}

TEST(JointRun, SameInputSameBytes) {
  const auto logs = test::SyntheticLogs(TruthOf(), 5.0, 0.001);
  EXPECT_EQ(CellToJson(Identify(logs).cell).dump(), CellToJson(Identify(logs).cell).dump());
}

TEST(JointRun, LogsThatDoNotStartFullAreNoTrouble) {
  const Cell truth = TruthOf();
  auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  // The pulses from 60 %.
  Record& record = logs.back().log.record;
  logs.back().entry.initial_soc = 0.6;
  record.voltage_V = Predict(truth, record.time_s, record.current_A, record.hold, 0.6).voltage_V;
  std::size_t rows = 0;
  while (record.voltage_V[rows] > 3.0) ++rows;
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) column->resize(rows);
  const JointResult result = Identify(logs);
  for (const char* parameter : {"alpha", "beta", "r_s", "r_1", "tau_1"}) {
    const double is = *CellParameter(truth, parameter);
    EXPECT_NEAR(*CellParameter(result.cell, parameter), is, 0.01 * is) << parameter;
  }
}

// Every log from 90 %: nothing moves them against one another, and v_oc leads to alpha as where all
// start full. Alpha is no less than what the slow discharge delivered says.
TEST(JointRun, LogsThatStartAlikeLeaveAlphaToTheCutoff) {
  const Cell truth = TruthOf();
  auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  double delivered_C = 0.0;
  for (LoadedLog& log : logs) {
    Record& record = log.log.record;
    log.entry.initial_soc = 0.9;
    record.voltage_V = Predict(truth, record.time_s, record.current_A, record.hold, 0.9).voltage_V;
    std::size_t rows = 0;
    while (rows < record.size() && record.voltage_V[rows] > 3.0) ++rows;
    rows = std::min(rows + 1, record.size());  // the row that crosses the cut-off
    for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V})
      column->resize(rows);
    delivered_C = std::max(delivered_C, DeliveredCharge(record).back());
  }
  const JointResult result = Identify(logs);
  EXPECT_EQ(result.alpha_source, "cut-off");
  EXPECT_TRUE(OneSays(result.cautions, "every log starts at initial_soc = 0.9"));
  for (const char* parameter : {"alpha", "beta", "r_s", "r_1", "tau_1"}) {
    const double is = *CellParameter(truth, parameter);
    EXPECT_NEAR(*CellParameter(result.cell, parameter), is, 0.005 * is) << parameter;
  }
  // The curve lies where it is, too: 2 mV are a hundredth of what 3 % of the charge would make of it.
  for (const double soc : {0.2, 0.5, 0.8})
    EXPECT_NEAR(result.cell.open_circuit_voltage(soc), truth.open_circuit_voltage(soc), 0.002);
  const QuantityTrust alpha = AssessJoint(result).quantities.front();
  ASSERT_EQ(alpha.name, "alpha");
  // But for the row in which the slow discharge crosses it.
  EXPECT_NEAR(result.least_alpha_C, delivered_C / 0.9, 3.0);
  EXPECT_GE(alpha.low, std::min(result.least_alpha_C, alpha.estimate));
}

// On a curve that is given over the whole charge alpha is an unknown like any other.
TEST(JointRun, AGivenCurveTellsAlpha) {
  const Cell truth = TruthOf();
  const auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  StagedGiven given;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  const JointResult result = Identify(logs, given);
  EXPECT_EQ(result.alpha_source, "least-squares");
  for (const char* parameter : {"alpha", "beta", "r_s", "r_1", "tau_1"}) {
    const double is = *CellParameter(truth, parameter);
    EXPECT_NEAR(*CellParameter(result.cell, parameter), is, 0.002 * is) << parameter;
  }
  // The curve is the very one, not one at nodes: nothing is left but noise.
  EXPECT_LT(result.rmse_V, 1.1 * kSmallNoise_V);
  const TrustReport trust = AssessJoint(result);
  const auto alpha = std::find_if(trust.quantities.begin(),
                                  trust.quantities.end(),
                                  [](const auto& one) { return one.name == "alpha"; });
  ASSERT_NE(alpha, trust.quantities.end());
  EXPECT_NEAR(alpha->estimate, truth.alpha_C(), 4.0 * alpha->standard_error);
  EXPECT_LT(alpha->standard_error, 0.002 * truth.alpha_C());
  given.alpha_C = 1300.0;
  EXPECT_EQ(Identify(logs, given).alpha_C, 1300.0);
}

// Pulses alone, and a label that is far off: within 1.5 of it another charge would be "identified", or none.
TEST(JointRun, AGivenCurveTellsAlphaWhateverTheLabel) {
  const Cell truth = TruthOf();
  const Record pulses = test::SimulateLog(
      truth,
      1.0,
      3000.0,
      [](double t) { return std::fmod(t - 1e-6, 300.0) < 100.0 ? 0.9 : 0.0; },
      "pulses.csv",
      kSmallNoise_V);
  const std::vector<LoadedLog> logs{test::AsLog(LogKind::kPulses, pulses)};
  StagedGiven given;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  for (const double label_Ah : {0.13, 0.25, 0.38, 0.6, 1.2}) {
    const JointResult result = IdentifyJoint(test::CampaignOf(logs, label_Ah), logs, {}, {}, given);
    SCOPED_TRACE(label_Ah);
    EXPECT_EQ(result.staged.alpha_source, "nominal-capacity");
    EXPECT_FALSE(result.alpha_not_found);
    EXPECT_NEAR(result.alpha_C, truth.alpha_C(), 1e-3 * truth.alpha_C());
  }
}

// Branches slower than a rest, with tables of resistances, stand in for an alpha of 2.29 Ah; the rests contradict.
TEST(JointRun, AlphaStaysWhereTheRestsLieOnTheGivenCurve) {
  constexpr double kPulsesTook_C = 3600.0 * 1.926;
  const Campaign campaign = ReadCampaign(test::LabDataPath("nasa_rw26_age4/campaign.toml"));
  const auto logs = LoadCampaign(campaign);
  StagedGiven given;
  given.open_circuit_voltage =
      ReadOpenCircuitVoltageFile(test::LabDataPath("nasa_rw26_age4/ocv_from_rests.csv"));
  const JointResult result = IdentifyJoint(campaign, logs, {}, {}, given);
  EXPECT_EQ(result.alpha_source, "rests");
  ASSERT_TRUE(result.alpha_of_rests.has_value());
  EXPECT_TRUE(OneSays(result.cautions, "rests lie on the given v_oc(A)"));
  EXPECT_NEAR(result.alpha_C, kPulsesTook_C, 0.005 * kPulsesTook_C);
  const TrustReport trust = AssessJoint(result);
  ASSERT_EQ(trust.quantities.front().name, "alpha");
  const QuantityTrust& alpha = trust.quantities.front();
  EXPECT_DOUBLE_EQ(alpha.standard_error, result.alpha_of_rests->error_C);
  EXPECT_EQ(alpha.verdict, Verdict::kIdentified);
  EXPECT_LT(alpha.low, kPulsesTook_C);
  EXPECT_GT(alpha.high, kPulsesTook_C);
  EXPECT_DOUBLE_EQ(trust.covariance(0, 0), alpha.standard_error * alpha.standard_error);
  // Whoever gives alpha has the last word.
  given.alpha_C = 7000.0;
  const JointResult by_hand = IdentifyJoint(campaign, logs, {}, {}, given);
  EXPECT_EQ(by_hand.alpha_C, 7000.0);
  EXPECT_FALSE(by_hand.alpha_of_rests.has_value());
}

// Pulses from 0.761 of the charge of which it is said that they begin at 0.85: alpha is looked for
// about the charge of the low-rate log, and not further away with every pass.
TEST(JointRun, AWrongStartLeadsAlphaNoFurtherThanItsBound) {
  auto logs = test::SyntheticLogs(test::Truth(), 5.0, kSmallNoise_V);
  Record& record = logs.back().log.record;
  constexpr std::size_t kFirst = 1000;  // 5,000 s, in the rest after the third pulse
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) {
    const std::vector<double> all = column->ToVector();
    *column = std::vector<double>(all.begin() + kFirst, all.end());
  }
  logs.back().entry.initial_soc = 0.95;
  const JointResult result = Identify(logs);
  EXPECT_EQ(result.alpha_source, "least-squares");
  EXPECT_LE(result.alpha_C, 1.501 * result.staged.low_rate_charge_C);
  EXPECT_TRUE(OneSays(result.cautions, "alpha is at a limit of its range"));
  EXPECT_TRUE(OneSays(result.cautions, "alpha rests on the initial_soc of these logs"));
  EXPECT_TRUE(OneSays(result.cautions, "pulses.csv (20 %)"));
}

// Two discharges and the pulses begin at 0.5, where 0.56 is said: alpha makes both starts right, and v_oc(A) is at the
// cut-off with charge left, which a cell that started full has not.
TEST(JointRun, AWrongStartIsDoubtedByTheEndOfTheCurve) {
  const Cell truth = TruthOf();
  const auto with = [&](double said) {
    auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
    for (LoadedLog* log : {&logs[1], &logs[2], &logs.back()}) {
      Record& record = log->log.record;
      record.voltage_V =
          Predict(truth, record.time_s, record.current_A, record.hold, 0.5).voltage_V;
      std::size_t rows = 0;
      while (rows < record.size() && record.voltage_V[rows] > 3.0) ++rows;
      rows = std::min(rows + 1, record.size());  // the row that crosses the cut-off
      for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V})
        column->resize(rows);
      log->entry.initial_soc = said;
    }
    return Identify(logs);
  };
  EXPECT_EQ(with(0.5).alpha_doubt, "");
  const JointResult wrong = with(0.56);
  ASSERT_GT(std::abs(wrong.alpha_C - truth.alpha_C()), 0.02 * truth.alpha_C());
  EXPECT_NE(wrong.alpha_doubt.find("% of that left: a full cell gives "), std::string::npos)
      << wrong.alpha_doubt;
  const auto at = wrong.alpha_doubt.find("which would make initial_soc ");
  ASSERT_NE(at, std::string::npos) << wrong.alpha_doubt;
  double would = 0.0;
  ASSERT_EQ(
      std::sscanf(wrong.alpha_doubt.c_str() + at, "which would make initial_soc %lf for", &would),
      1);
  EXPECT_NEAR(would, 0.5, 0.01);
}

// ---- little data -------------------------------------------------------------------------------

TEST(JointRun, AGivenCurveAndOnePulseAreAProblem) {
  const Cell truth = TruthOf();
  auto all = test::SyntheticLogs(truth, 1.0, kSmallNoise_V);
  Record record = all.back().log.record;
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) column->resize(1800);
  const std::vector<LoadedLog> logs{test::AsLog(LogKind::kPulses, record)};
  StagedGiven given;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  given.alpha_C = truth.alpha_C();
  const JointResult result = Identify(logs, given);
  EXPECT_TRUE(OneSays(result.cautions, "too few pulses"));
  EXPECT_EQ(result.choice.best.structure.nodes(), 1);
  EXPECT_NEAR(*CellParameter(result.cell, "r_s"), *CellParameter(truth, "r_s"), 0.002);
  EXPECT_LT(result.fitted.front().all.rmse, 1.2 * kSmallNoise_V);
}

TEST(JointRun, OneCurrentALogThatStopsEarlyAndSlowSamplingGiveAnAnswer) {
  const Cell truth = TruthOf();
  const auto all = test::SyntheticLogs(truth, 60.0, kSmallNoise_V);
  const auto pulses = test::SimulateLog(
      truth,
      60.0,
      1e5,
      [](double t) { return std::fmod(t - 1e-6, 3600.0) < 600.0 ? 0.6 : 0.0; },
      "pulses.csv",
      kSmallNoise_V);
  // A minute between rows, one current, and a low rate that ends half way.
  std::vector<LoadedLog> logs{all[0], all[3], test::AsLog(LogKind::kPulses, pulses)};
  Record& low = logs[1].log.record;
  const std::size_t half = low.size() / 2;
  for (auto* column : {&low.time_s, &low.current_A, &low.voltage_V}) column->resize(half);
  const JointResult result = Identify(logs);
  EXPECT_TRUE(std::isfinite(result.rmse_V));
  EXPECT_LT(result.rmse_V, 0.01);
  EXPECT_GT(result.alpha_C, 0.0);
}

TEST(JointRun, AThesisBranchThatIsNotThereIsNamed) {
  Cell truth = LoadCell("gifi-600mAh-1");
  truth.branches.clear();
  const auto logs = test::SyntheticLogs(truth, 1.0, kSmallNoise_V);
  const JointResult result = Identify(logs, {}, {.branches = 1});
  EXPECT_TRUE(OneSays(result.cautions, "branch 1 was not found"))
      << *CellParameter(result.cell, "r_1");
}

// ---- what the user knows -----------------------------------------------------------------------

std::string OptionErrorOf(const GivenParameters& parameters, int branches = 1) {
  StagedGiven given;
  given.parameters = parameters;
  JointOptions options;
  options.branches = branches;
  const auto logs = test::SyntheticLogs(TruthOf(), 30.0);
  return test::MessageOf<OptionError>(
      [&] { static_cast<void>(IdentifyJoint(test::CampaignOf(logs), logs, {}, options, given)); });
}

TEST(JointRun, RefusesWhatItCannotUse) {
  EXPECT_EQ(
      OptionErrorOf({.fixed = {{"c_1", 1000.0}}}),
      "--fix c_1: the joint method knows branches by their time constants; fix tau_1 instead");
  EXPECT_EQ(OptionErrorOf({.start = {{"beta", 0.3}}}),
            "--start beta: the joint method searches a grid and needs no start");
  EXPECT_EQ(OptionErrorOf({.start = {{"c_1", 1500.0}}}, -1),
            "--start c_1: the joint method searches a grid and needs no start");
  EXPECT_EQ(OptionErrorOf({.bounds = {{"r_s", {0.0, 1.0}}}}),
            "--bounds r_s: the joint method bounds beta and tau_j");
  EXPECT_EQ(OptionErrorOf({.fixed = {{"tau_1", 10.0}}}, -1),
            "--fix and --bounds of a branch need --branches: without it the joint method chooses "
            "how many branches there are");
}

// What no cell file may hold was once accepted by this method alone.
TEST(JointRun, RefusesWhatNoCellCanHave) {
  EXPECT_EQ(OptionErrorOf({.fixed = {{"r_9", 0.1}}}),
            "--fix: no parameter 'r_9' in this fit; there are beta, r_s, r_1, tau_1, c_1");
  EXPECT_EQ(OptionErrorOf({.fixed = {{"tau_1x", 10.0}}}, 2),
            "--fix: no parameter 'tau_1x' in this fit; there are beta, r_s, r_1, r_2, tau_1, "
            "tau_2, c_1, c_2");
  EXPECT_EQ(OptionErrorOf({.fixed = {{"r_s", -1.0}}}),
            "--fix r_s=-1: expected a resistance of at least 0 Ohm");
  EXPECT_EQ(OptionErrorOf({.fixed = {{"beta", 5.0}}}),
            "--fix beta=5: expected a number from 0.0001 to 1");
  EXPECT_EQ(OptionErrorOf({.bounds = {{"tau_2", {1.0, 10.0}}}}),
            "--bounds: no parameter 'tau_2' in this fit; there are beta, r_s, r_1, tau_1, c_1");
  EXPECT_EQ(OptionErrorOf({.bounds = {{"tau_1", {10.0, 1.0}}}}),
            "--bounds tau_1=10,1: expected 0 <= low <= high");
  EXPECT_EQ(OptionErrorOf({.bounds = {{"beta", {0.1, 5.0}}}}),
            "--bounds beta=0.1,5: expected 0 <= low <= high <= 1");
}

// No current and no rest lasts longer than 1,770 s. Nobody asks for more where the branch is fast.
TEST(JointRun, ABranchSlowerThanEverySegmentIsLetInWhereItIsThere) {
  Cell slow = TruthOf();
  const double r_Ohm = *CellParameter(slow, "r_1");
  slow.branches = {{Resistance<double>(r_Ohm), 4000.0, 4000.0 / r_Ohm}};
  const JointResult result = Identify(test::SyntheticLogs(slow, 5.0, kSmallNoise_V));
  EXPECT_TRUE(result.setup.slow_branches);
  EXPECT_TRUE(OneSays(result.cautions, "the longest time at one current: time constants of up to"));
  ASSERT_EQ(result.cell.branches.size(), 1U);
  const auto trust = AssessJoint(result).quantities;
  const auto tau = std::find_if(
      trust.begin(), trust.end(), [](const QuantityTrust& q) { return q.name == "tau_1"; });
  ASSERT_NE(tau, trust.end());
  EXPECT_GT(tau->low, 1770.0);
  EXPECT_LE(tau->low, 4000.0);
  EXPECT_GE(tau->high, 4000.0);
  const JointResult fast = Identify(test::SyntheticLogs(TruthOf(), 5.0, kSmallNoise_V));
  EXPECT_FALSE(fast.setup.slow_branches);
  EXPECT_FALSE(OneSays(fast.cautions, "the longest time at one current"));
}

// The free branch is the faster one: sorted by time constants it would be the first, and the report
// would say of the wrong one that it is held.
TEST(JointRun, ABranchThatIsNamedKeepsItsNumber) {
  const Cell truth = TruthOf();
  const auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  StagedGiven given;
  given.parameters.fixed = {{"tau_1", 100.0}, {"r_1", 0.002}};
  JointOptions options;
  options.branches = 2;
  options.resistance_nodes = 1;
  options.self_heating = options.charge_transfer = Presence::kOff;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, options, given);
  ASSERT_EQ(result.cell.branches.size(), 2U);
  EXPECT_EQ(result.cell.branches[0].time_constant_s, 100.0);
  EXPECT_NEAR(*CellParameter(result.cell, "r_1"), 0.002, 1e-15);
  EXPECT_LT(result.cell.branches[1].time_constant_s, 60.0);
  std::vector<std::string> reported;
  for (const auto& quantity : AssessJoint(result).quantities) reported.push_back(quantity.name);
  EXPECT_EQ(
      reported,
      (std::vector<std::string>{"alpha", "beta", "r_s", "r_2", "tau_2", "c_2", "r_total(0.5)"}));
}

TEST(JointRun, WithoutDiffusionThereIsNoBeta) {
  Cell truth = TruthOf();
  truth.diffusion.reset();
  const auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  StagedOptions staged;
  staged.pulses.diffusion = false;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, staged);
  EXPECT_FALSE(result.cell.diffusion);
  EXPECT_NEAR(*CellParameter(result.cell, "r_s"), *CellParameter(truth, "r_s"), 1e-3);
  EXPECT_NEAR(*CellParameter(result.cell, "tau_1"), 45.0, 1.0);
}

// A bound that somebody gave is no word of the logs.
TEST(JointRun, SaysWhoseLimitBetaStandsAt) {
  const Cell truth = TruthOf();
  StagedGiven given;
  given.parameters.bounds["beta"] = {0.05, 0.8 * truth.diffusion->beta_per_sqrt_s};
  const auto said = Identify(test::SyntheticLogs(truth, 5.0, kSmallNoise_V), given).cautions;
  EXPECT_TRUE(OneSays(said, "beta is at the limit that --bounds gives it"))
      << testing::PrintToString(said);
  EXPECT_FALSE(OneSays(said, "no diffusion"));
}

// Held at its limit, beta took half a percent of r_s.
TEST(JointRun, DiffusionThatNoLogShowsIsLeftOut) {
  Cell truth = TruthOf();
  truth.diffusion.reset();
  const auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  const JointResult result = Identify(logs);
  EXPECT_FALSE(result.cell.diffusion);
  EXPECT_TRUE(OneSays(result.cautions, "these logs show no diffusion"));
  EXPECT_FALSE(OneSays(result.cautions, "beta is at its limit"));
  const double r_s = *CellParameter(truth, "r_s");
  EXPECT_NEAR(*CellParameter(result.cell, "r_s"), r_s, 0.002 * r_s);
  EXPECT_NEAR(result.cell.capacity_Ah, truth.capacity_Ah, 1e-3 * truth.capacity_Ah);
  // Structures that had diffusion at its limit do not widen the interval by what it took.
  const TrustReport trust = AssessJoint(result);
  const QuantityTrust* known = FindQuantity(trust, "r_s");
  ASSERT_NE(known, nullptr);
  EXPECT_LE(known->low, r_s);
  EXPECT_GE(known->high, r_s);
  EXPECT_LT(known->high - known->low, 0.01 * r_s);

  StagedGiven within;
  within.parameters.bounds = {{"beta", {0.01, 1.0}}};
  EXPECT_TRUE(Identify(logs, within).cell.diffusion);
  EXPECT_TRUE(Identify(test::SyntheticLogs(TruthOf(), 5.0, kSmallNoise_V)).cell.diffusion);
}

// ---- real cells --------------------------------------------------------------------------------

LogErrors Of(const std::vector<LogErrors>& all, const std::string& file) {
  const auto found =
      std::find_if(all.begin(), all.end(), [&](const auto& log) { return log.file == file; });
  EXPECT_NE(found, all.end()) << file;
  return found == all.end() ? LogErrors{} : *found;
}

// The figures are those of the issue that asked for this method.
TEST(JointRun, PredictsTheRandomWalkOfDmegc) {
  const auto file = test::LabDataPath("dmegc_inr18650_26_r1/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const Campaign campaign = ReadCampaign(file);
  const JointResult result = IdentifyJoint(campaign, LoadCampaign(campaign));
  EXPECT_LT(Of(result.validation, "random_walk_01.csv").all.mean_error_percent, 0.35);
  EXPECT_GT(Of(result.staged.validation, "random_walk_01.csv").all.mean_error_percent, 1.0);
  EXPECT_LT(Of(result.fitted, "pulse.csv").all.rmse,
            1.2 * Of(result.fitted_staged, "pulse.csv").all.rmse);
}

TEST(JointRun, PredictsTheConstantCurrentsOfNissanAndTheirRepeats) {
  const auto file = test::LabDataPath("nissan_leaf_33ah/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const Campaign campaign = ReadCampaign(file);
  const JointResult result = IdentifyJoint(campaign, LoadCampaign(campaign));
  for (const char* log : {"cc_1c.csv", "cc_2c.csv", "cc_3c.csv"})
    EXPECT_LT(Of(result.fitted, log).all.mean_error_percent, 0.12) << log;
  EXPECT_LT(Of(result.fitted, "pulse.csv").all.rmse,
            1.2 * Of(result.fitted_staged, "pulse.csv").all.rmse);
  for (const char* log : {"cc_1c_rep2.csv", "cc_2c_rep3.csv", "cc_3c_rep4.csv"}) {
    const Record repeat =
        ReadLog(test::LabDataPath("nissan_leaf_33ah/repeats/" + std::string(log))).record;
    EXPECT_LT(Validate(result.cell, repeat).all.mean_error_percent, 0.25) << log;
  }
  // The rows of 3C are as far apart as the nodes, so that free branches go up and down between 0 and
  // 4 mOhm from one node to the next.
  EXPECT_GT(result.choice.best.structure.branch_smoothness, 1.0);
  EXPECT_TRUE(OneSays(result.cautions, "as smooth over the state of charge as r_s"));
  ASSERT_EQ(result.cell.branches.size(), 1U);
  const Resistance<double>& branch = result.cell.branches[0].resistance_Ohm;
  int turns = 0;
  double before_Ohm = 0.0;
  for (double soc = 0.1; soc <= 0.95; soc += 0.01) {
    const double rise_Ohm = branch(soc) - branch(soc - 0.01);
    if (rise_Ohm * before_Ohm < 0.0) ++turns;
    if (rise_Ohm != 0.0) before_Ohm = rise_Ohm;
  }
  EXPECT_LE(turns, 6);
}

// v_oc is seen far above the cut-off only, and each pulse starts where its file says: A = 0 where a
// straight line reaches the cut-off would make it a cell of 6.6 Ah, of which nothing fits. What the
// cell drops within the 10 s of the pulse at half charge is what the log of it shows (the data's
// README).
// Fitted were 0.07 % of cc_2c, and the cell missed it by 0.44 %: near empty the heat had taken more from r_s
// than a cell lets it. What is to be expected of new logs is no less than the errors of these.
TEST(JointRun, TheHeatThatIsFittedIsTheHeatOfTheCell) {
  const auto file = test::LabDataPath("lg_m50_5ah/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const Campaign campaign = ReadCampaign(file);
  const auto logs = LoadCampaign(campaign);
  const JointResult result = IdentifyJoint(campaign, logs);
  EXPECT_LT(Of(result.fitted, "cc_2c.csv").all.mean_error_percent, 0.25);
  double own_percent = 0.0;
  for (const LogErrors& log : result.fitted) own_percent += log.all.mean_error_percent;
  own_percent /= static_cast<double>(result.fitted.size());
  const JointObservations seen(result.logs, result.setup);
  const ExpectedError expected =
      ExpectError(JointFit(seen, {}), result.logs, result.choice.best, AssessJoint(result));
  EXPECT_GT(expected.percent, 0.9 * own_percent);
}

TEST(JointRun, FindsTheChargeThatBringsLogsOfManyStartsTogether) {
  // At 0 degC full is what the charger reached there, some 95 % of what it reaches at 25 degC, but
  // pulses begin at shares of the whole: the charge is known to a tenth.
  const std::tuple<const char*, double, double, double> cases[] = {
      {"t00", 4.8, 0.1, 0.0502}, {"t25", 4.8, 0.05, 0.0362}, {"t45", 4.9, 0.05, 0.0343}};
  for (const auto& [folder, charge_Ah, share, after_10_s_Ohm] : cases) {
    const auto file =
        test::LabDataPath(std::string("lg_m50_temperatures/") + folder + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    const Campaign campaign = ReadCampaign(file);
    const std::vector<LoadedLog> logs = LoadCampaign(campaign);
    const JointResult result = IdentifyJoint(campaign, logs);
    EXPECT_EQ(result.alpha_source, "least-squares") << folder;
    // In the valleys of other charges, in which simple structures end, 1.3 to 1.8 mV.
    EXPECT_LT(result.rmse_V, 1.2e-3) << folder;
    // Of nine starts the five that matter most.
    EXPECT_TRUE(
        OneSays(result.cautions, "in brackets: pulse_soc90.csv (10 %), pulse_soc80.csv (5 %)"));
    EXPECT_TRUE(OneSays(result.cautions, "pulse_soc50.csv (2 %), 4 more")) << folder;
    EXPECT_NEAR(result.alpha_C / 3600.0, charge_Ah, share * charge_Ah) << folder;
    const auto half = std::find_if(logs.begin(), logs.end(), [](const LoadedLog& log) {
      return log.entry.file == "pulse_soc50.csv";
    });
    ASSERT_NE(half, logs.end());
    const Record& pulse = half->log.record;
    const Prediction predicted = Predict(result.cell,
                                         pulse.time_s,
                                         pulse.current_A,
                                         pulse.hold,
                                         half->entry.initial_soc,
                                         SurroundingsOf(pulse, half->entry));
    std::size_t last = 0;  // under load
    for (std::size_t k = 0; k < pulse.size(); ++k) {
      if (pulse.current_A[k] > 1.0) last = k;
    }
    const double drop_Ohm =
        (predicted.voltage_V.front() - predicted.voltage_V[last]) / pulse.current_A[last];
    EXPECT_NEAR(drop_Ohm, after_10_s_Ohm, 0.04 * after_10_s_Ohm) << folder;
  }
}

// Without a low-rate log the curve starts from the rests of the pulses. v_oc is fitted all the
// same, and the truth comes back: the discharges show its shape between the rests.
TEST(JointRun, FindsTheTruthWithoutALowRateLog) {
  const Cell truth = TruthOf();
  auto logs = test::SyntheticLogs(truth, 5.0, kSmallNoise_V);
  logs.erase(logs.begin() + 3);
  const JointResult result = Identify(logs);
  EXPECT_TRUE(result.converged);
  ASSERT_TRUE(result.staged.from_rests.has_value());
  EXPECT_EQ(result.alpha_source, "cut-off");
  for (const char* parameter : {"alpha", "beta", "r_s", "r_1", "tau_1"}) {
    const double is = *CellParameter(truth, parameter);
    EXPECT_NEAR(*CellParameter(result.cell, parameter), is, 0.02 * is) << parameter;
  }
  EXPECT_LT(result.fitted.back().all.rmse, 1.2 * kSmallNoise_V);
}

// The first part of a log: a test that was stopped.
LoadedLog Stopped(LoadedLog log, double share) {
  Record& record = log.log.record;
  const auto rows = static_cast<std::size_t>(share * static_cast<double>(record.size()));
  for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V}) column->resize(rows);
  return log;
}

// Below half of the charge there is a slow discharge alone. Free resistances took part of it there, up to
// a hundred times those of the cell.
TEST(JointRun, FarFromEveryLoadResistancesGoOn) {
  Cell truth = TruthOf();
  truth.series_resistance_Ohm = {{0.0, 0.3, 1.0}, {0.16, 0.14, 0.13}};
  const auto all = test::SyntheticLogs(truth, 2.0, kSmallNoise_V);
  const std::vector<LoadedLog> logs{all[3], Stopped(all[4], 0.5)};
  const JointResult result = Identify(logs, {}, {.resistance_nodes = 13});
  EXPECT_TRUE(OneSays(result.cautions, "of the charge: beyond, resistances are taken to go on"));
  const auto total = [](const Cell& cell, double soc) {
    return cell.series_resistance_Ohm(soc) + cell.branches[0].resistance_Ohm(soc);
  };
  for (const double soc : {0.05, 0.15, 0.3}) {
    EXPECT_GT(total(result.cell, soc), 0.7 * total(truth, soc)) << soc;
    EXPECT_LT(total(result.cell, soc), 1.4 * total(truth, soc)) << soc;
  }
  EXPECT_NEAR(result.alpha_C, truth.alpha_C(), 0.005 * truth.alpha_C());
  // What goes on by assumption is no row of the report.
  std::vector<std::string> reported;
  for (const auto& quantity : AssessJoint(result).quantities) reported.push_back(quantity.name);
  const auto has = [&](const char* name) {
    return std::find(reported.begin(), reported.end(), name) != reported.end();
  };
  EXPECT_TRUE(has("r_s(0.8)"));
  EXPECT_FALSE(has("r_s(0.2)") || has("r_1(0.2)"));
  EXPECT_FALSE(OneSays(Identify(all).cautions, "resistances are taken to go on"));
}

// A curve and a structure that are given leave three rates to a search by steps, alpha among them. Its coordinate was
// so large that steps of a fifth of the others were small beside it: tau_1 was 34.7 s of 45, and "converged".
TEST(JointRun, AlphaBesideAGivenCurveDoesNotEndTheSearchOfTheOthers) {
  const Cell truth = test::Truth();
  for (const std::uint64_t seed : {1U, 2U, 3U, 4U, 5U, 6U}) {
    std::vector<LoadedLog> logs;
    for (const double rate : {1.0, 2.0, 3.0, 4.0}) {
      const double current_A = rate * truth.capacity_Ah;
      logs.push_back(test::AsLog(
          LogKind::kConstantCurrent,
          test::SimulateLog(
              truth, 1.0, 4000.0, [=](double) { return current_A; }, fmt::format("{}.csv", rate))));
    }
    test::AddColouredNoise(logs, 0.0003, 0.0002, seed);
    StagedGiven given;
    given.open_circuit_voltage = truth.open_circuit_voltage;
    const JointResult result = Identify(logs, given, test::kPlainJoint);
    for (const char* parameter : {"alpha", "beta", "r_s", "r_1", "tau_1"}) {
      const double is = *CellParameter(truth, parameter);
      EXPECT_NEAR(*CellParameter(result.cell, parameter), is, 0.03 * is)
          << parameter << " " << seed;
    }
    // The search of the structure ended there, too, and the last one beside it: what another structure says is no spread.
    const JointSolution& found = result.choice.tried.front().solution;
    EXPECT_NEAR(found.rates.time_constant_s[0], result.choice.best.rates.time_constant_s[0], 0.1);
  }
}

// Modes beyond M count as a resistance: where the next of them is slower than the rows, r_s is not r_s.
TEST(JointRun, SaysWhereMoreModesOfTheDiffusionAreWanted) {
  Cell truth = TruthOf();
  EXPECT_FALSE(OneSays(Identify(test::SyntheticLogs(truth, 2.0, kSmallNoise_V)).cautions, "modes"));
  truth.diffusion->beta_per_sqrt_s = 0.08;  // 1/(11 beta)^2 = 1.3 s
  truth.diffusion->terms = 60;
  EXPECT_TRUE(OneSays(Identify(test::SyntheticLogs(truth, 1.0, kSmallNoise_V)).cautions,
                      "diffusion is counted in 10 modes, and the next, of "));
}

// A slow discharge counts what a faulty zero adds for twenty hours, and no other discharge shows it.
TEST(JointRun, SaysWhatTheZeroOfTheCurrentSensorWouldDoToAlpha) {
  auto logs = test::SyntheticLogs(TruthOf(), 20.0, kSmallNoise_V);
  EXPECT_TRUE(
      OneSays(Identify(logs).cautions, "alpha takes the zero of the current sensor as exact"));
  EXPECT_FALSE(OneSays(Identify(logs).cautions, "At rest it shows"));
  for (auto& log : logs) {
    for (double& current_A : log.log.record.current_A) current_A += 1e-3;
  }
  EXPECT_TRUE(OneSays(Identify(logs).cautions, "At rest it shows 1 mA: if none flows there"));
  std::erase_if(logs, [](const auto& log) { return log.entry.kind == LogKind::kLowRate; });
  EXPECT_FALSE(OneSays(Identify(logs).cautions, "the zero of the current sensor"));
}

// Pulses that end at 3.7 V say nothing of the charge below: the last slope of their v_oc led to 1.5
// times the charge, with an interval that missed it.
TEST(JointRun, LogsThatEndFarAboveTheCutoffLeaveAlphaToTheNominalCapacity) {
  const Cell truth = TruthOf();
  const std::vector<LoadedLog> logs{
      Stopped(test::SyntheticLogs(truth, 2.0, kSmallNoise_V)[4], 0.5)};
  const double nominal_Ah = truth.alpha_C() / 3600.0;
  const JointResult result = IdentifyJoint(test::CampaignOf(logs, nominal_Ah), logs);
  EXPECT_EQ(result.alpha_source, "nominal-capacity");
  EXPECT_NEAR(result.alpha_C, truth.alpha_C(), 1e-9 * truth.alpha_C());
  EXPECT_NE(result.alpha_doubt.find("a log down to the cut-off would tell"), std::string::npos);
  EXPECT_TRUE(OneSays(result.cautions, "(the nominal capacity)"));
}

// A slow discharge that was stopped gives v_oc where it went, and others the charge.
TEST(JointRun, ASlowDischargeThatWasStoppedIsNotTheCharge) {
  const Cell truth = TruthOf();
  const auto all = test::SyntheticLogs(truth, 2.0, kSmallNoise_V);
  const std::vector<LoadedLog> logs{all[0], all[1], Stopped(all[3], 0.4), all[4]};
  const JointResult result = Identify(logs);
  EXPECT_EQ(result.alpha_source, "cut-off");
  EXPECT_NEAR(result.alpha_C, truth.alpha_C(), 0.02 * truth.alpha_C());
  EXPECT_TRUE(result.alpha_doubt.empty()) << result.alpha_doubt;
}

// Rows on the steep end of a curve that no slow log saw count by its slope, as found, and resistances and beta stay
// what they are: with the slope of the part above they were off by 3 % and 7 standard errors.
TEST(JointRun, ASlowDischargeThatWasStoppedBendsNothing) {
  const Cell truth = test::Truth();
  const auto folder = test::FreshFolder("joint_run.stopped");
  RunRecord run;
  run.seed = 1;
  Synthesize(truth, kProtocols[0], {.sampling_s = 2.0, .voltage_noise_V = 0.001}, run, folder);
  auto logs = LoadCampaign(ReadCampaign(folder + "/campaign.toml"));
  for (LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kLowRate) log = Stopped(log, 0.8);
  }
  const JointResult result = Identify(logs);
  for (const char* parameter : {"beta", "r_s", "r_1", "tau_1"}) {
    const double is = *CellParameter(truth, parameter);
    const auto found = CellParameter(result.cell, parameter);
    ASSERT_TRUE(found.has_value()) << parameter;
    EXPECT_NEAR(*found, is, 0.012 * is) << parameter;
  }
}

// Logs that begin under load: a branch is added beside structures without self-heating, of which nothing is asked.
TEST(JointRun, LogsThatBeginUnderLoadAreFitted) {
  const auto folder = test::FreshFolder("joint_run.loaded");
  RunRecord run;
  run.seed = 1;
  Synthesize(
      test::Truth(), kProtocols[0], {.sampling_s = 2.0, .voltage_noise_V = 0.001}, run, folder);
  auto logs = LoadCampaign(ReadCampaign(folder + "/campaign.toml"));
  for (LoadedLog& log : logs) {
    if (log.entry.kind != LogKind::kConstantCurrent) continue;
    Record& record = log.log.record;
    for (auto* column : {&record.time_s, &record.current_A, &record.voltage_V})
      *column = Column(column->begin() + 1, column->end());
  }
  const JointResult result = Identify(logs);
  EXPECT_TRUE(result.converged);
  EXPECT_NEAR(result.alpha_C, test::Truth().alpha_C(), 0.01 * test::Truth().alpha_C());
}

// The refitted curve stays near the rests, whose own drift is up to 9 mV, above a quarter of the
// charge. Below, v_oc and a branch as slow as the rests cannot be told apart by logs of one current
// (docs/joint.md, 7): there it may leave them by some ten millivolts.
constexpr double kNearRests_V = 0.015;
constexpr double kSteep_V = 0.1;
constexpr double kSteepBelow_soc = 0.25;

// By the curve of their own rests. The fit alone went to 2.25 and 2.29 Ah at the ages 3 and 4, with a
// branch of 12,000 s that made up for it.
TEST(JointRun, NasaHasTheChargeOfItsPulsesWhereTheCurveOfItsRestsIsGiven) {
  constexpr double kOfPulses_Ah[] = {2.146, 2.039, 1.972, 1.926, 1.887};  // README of the data
  bool by_rests = false;
  for (const int age : {1, 2, 3, 4, 5}) {
    const std::string folder = "nasa_rw26_ageing/age" + std::to_string(age);
    const auto file = test::LabDataPath(folder + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    SCOPED_TRACE(file);
    Campaign campaign = ReadCampaign(file);
    std::erase_if(campaign.logs, [](const auto& log) { return log.kind == LogKind::kValidation; });
    StagedGiven given;
    given.open_circuit_voltage =
        ReadOpenCircuitVoltageFile(test::LabDataPath(folder + "/ocv_from_rests.csv"));
    const JointResult result = IdentifyJoint(campaign, LoadCampaign(campaign), {}, {}, given);
    const double alpha_C = 3600.0 * kOfPulses_Ah[age - 1];
    EXPECT_NEAR(result.alpha_C, alpha_C, 0.01 * alpha_C);
    const TrustReport trust = AssessJoint(result);
    const auto alpha = std::find_if(trust.quantities.begin(),
                                    trust.quantities.end(),
                                    [](const auto& one) { return one.name == "alpha"; });
    ASSERT_NE(alpha, trust.quantities.end());
    EXPECT_EQ(alpha->verdict, Verdict::kIdentified);
    EXPECT_GT(alpha->standard_error, 0.0);
    // 2.039 Ah were read off with as many digits.
    EXPECT_LT(alpha->low, alpha_C + 4.0);
    EXPECT_GT(alpha->high, alpha_C - 4.0);
    const bool said = OneSays(result.cautions, "rests lie on the given v_oc(A)");
    EXPECT_EQ(said, result.alpha_source == "rests");
    EXPECT_EQ(said, result.alpha_of_rests.has_value());
    by_rests = by_rests || said;
  }
  EXPECT_TRUE(by_rests);
}

TEST(JointRun, IdentifiesNasaAtFiveAgesWithoutALowRateLog) {
  for (const int age : {1, 2, 3, 4, 5}) {
    const auto file =
        test::LabDataPath("nasa_rw26_ageing/age" + std::to_string(age) + "/campaign.toml");
    LIPOID_SKIP_WITHOUT(file);
    SCOPED_TRACE(file);
    const Campaign campaign = ReadCampaign(file);
    const JointResult result = IdentifyJoint(campaign, LoadCampaign(campaign));
    EXPECT_TRUE(result.staged.converged);
    EXPECT_TRUE(result.converged);
    EXPECT_EQ(result.staged.alpha_source, "pulse-charge");
    EXPECT_EQ(result.alpha_source, "cut-off");
    ASSERT_TRUE(result.staged.from_rests.has_value());
    const double to_C = result.staged.alpha_C;
    for (const SettledRest& rest : result.staged.from_rests->rests) {
      const double soc = 1.0 - (1.0 - rest.soc) * to_C / result.alpha_C;
      const double near_V = rest.soc > kSteepBelow_soc ? kNearRests_V : kSteep_V;
      EXPECT_NEAR(result.cell.open_circuit_voltage(soc), rest.voltage_V, near_V) << rest.soc;
    }
    ASSERT_EQ(result.validation.size(), 4U);
    for (const LogErrors& log : result.validation) {
      EXPECT_LT(log.all.mean_error_percent, 1.5) << log.file;
    }
    for (const LogErrors& log : result.staged.validation)
      EXPECT_LT(log.all.mean_error_percent, 1.5) << log.file;
  }
}

TEST(JointRun, SaysWhatItTriedInItsSummary) {
  const auto logs = test::SyntheticLogs(TruthOf(), 10.0, kSmallNoise_V);
  const JointResult result = Identify(logs);
  const Json json = JointToJson(result, AssessJoint(result));
  EXPECT_EQ(json.at("parameters")[0].at("name"), "alpha");
  EXPECT_TRUE(json.at("trust").contains("sentence"));
  EXPECT_EQ(json.at("method"), "joint");
  EXPECT_EQ(json.at("joint").at("resistance_nodes"), 1);
  EXPECT_GT(json.at("joint").at("tried").size(), 6U);
  EXPECT_EQ(json.at("logs").size(), logs.size());
  EXPECT_TRUE(json.at("logs")[0].contains("staged"));
  EXPECT_TRUE(json.at("stages").contains("pulses"));
}

}  // namespace
}  // namespace lipoid
