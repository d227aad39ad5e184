#include "identify/stages/staged_run.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "identify/stages/staged_report.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "tests/support/load_error.h"
#include "tests/support/paths.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

// Whether one of the sentences holds the words.
bool OneSays(const std::vector<std::string>& sentences, const std::string& words) {
  return std::any_of(sentences.begin(), sentences.end(), [&](const std::string& sentence) {
    return sentence.find(words) != std::string::npos;
  });
}

// Table 4.11 with a branch that can be seen.
using test::Truth;

using test::AsLog;
using test::CampaignOf;
using test::SimulateLog;

LoadedLog ConstantCurrent(const Cell& cell, double rate) {
  return AsLog(LogKind::kConstantCurrent,
               SimulateLog(
                   cell,
                   1.0,
                   2.0 * 3600.0 / rate,
                   [&](double) { return 0.6 * rate; },
                   "cc_" + std::to_string(int(rate)) + "C.csv"));
}
LoadedLog LowRate(const Cell& cell) {
  return AsLog(LogKind::kLowRate,
               SimulateLog(
                   cell, 10.0, 1e5, [](double) { return 0.05; }, "low_rate.csv"));
}
LoadedLog Pulses(const Cell& cell) {
  return AsLog(LogKind::kPulses,
               SimulateLog(
                   cell,
                   1.0,
                   1e5,
                   [](double t) { return std::fmod(t - 1e-6, 1800.0) < 30.0 ? 3.6 : 0.0; },
                   "pulses.csv"));
}

StagedResult Identify(const std::vector<LoadedLog>& logs,
                      const StagedGiven& given = {},
                      const StagedOptions& options = {}) {
  return IdentifyStaged(CampaignOf(logs), logs, options, given);
}

// Without noise nothing but rounding and the solver's tolerances stands between truth and estimate.
constexpr double kExactRelative = 1e-6;
// What the method leaves out: the low-rate log lies 8 mV, 0.2 %, below v_oc, and the pulses feel
// half as much again from alpha.
constexpr double kMethodErrorPercent = 0.3;

TEST(StagedRun, FindsEveryParameterWhenAlphaAndTheCurveAreGiven) {
  const Cell truth = Truth();
  StagedGiven given;
  given.alpha_C = truth.diffusion->alpha_C;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  const StagedResult result = Identify(
      {ConstantCurrent(truth, 1.0), ConstantCurrent(truth, 2.0), LowRate(truth), Pulses(truth)},
      given);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.alpha_source, "given");
  const Cell& cell = result.cell;
  EXPECT_EQ(cell.diffusion->alpha_C, truth.diffusion->alpha_C);
  EXPECT_NEAR(
      cell.diffusion->beta_per_sqrt_s / truth.diffusion->beta_per_sqrt_s, 1.0, kExactRelative);
  EXPECT_NEAR(cell.series_resistance_Ohm.resistance_Ohm[0] / 0.1314, 1.0, kExactRelative);
  EXPECT_NEAR(cell.branches[0].resistance_Ohm.resistance_Ohm[0] / 0.03, 1.0, kExactRelative);
  EXPECT_NEAR(*cell.branches[0].capacitance_F / 1500.0, 1.0, kExactRelative);
  EXPECT_TRUE(result.pulses.at_bound.empty());
}

// The charge that left is no part of a cell that held none.
TEST(StagedRun, RefusesADischargeFromEmpty) {
  const Cell truth = Truth();
  for (const double initial_soc : {0.0, -0.1}) {
    LoadedLog low_rate = LowRate(truth);
    low_rate.entry.initial_soc = initial_soc;
    EXPECT_NE(
        test::LoadErrorOf([&] {
          (void)Identify({low_rate, Pulses(truth)}, {});
        }).find("expected a discharge from a state of charge above 0, found an initial_soc of"),
        std::string::npos)
        << initial_soc;
  }
}

TEST(StagedRun, FindsTheCellFromItsLogsAsWellAsTheMethodCan) {
  const Cell truth = Truth();
  std::vector<LoadedLog> logs;
  for (const double rate : {1.0, 2.0, 3.0, 4.0}) logs.push_back(ConstantCurrent(truth, rate));
  logs.push_back(LowRate(truth));
  logs.push_back(Pulses(truth));
  logs.push_back(AsLog(LogKind::kValidation, ConstantCurrent(truth, 5.0).log.record));
  const StagedResult result = Identify(logs);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.alpha_source, "discharge-times");
  ASSERT_TRUE(result.discharge_times.has_value());
  EXPECT_TRUE(result.discharge_times->identifiable);
  // The ohmic drop at cut-off ends a discharge early, so that alpha is a little low and beta far
  // too low: the method's own bias (docs/theory.md), which (4.61) mends.
  EXPECT_NEAR(result.alpha_C / truth.diffusion->alpha_C, 1.0, 0.02);
  EXPECT_LT(result.discharge_times->beta_per_sqrt_s, truth.diffusion->beta_per_sqrt_s);
  EXPECT_LT(result.pulses.errors.mean_error_percent, kMethodErrorPercent);
  EXPECT_LT(result.pulses.errors.rmse, result.pulses_beta_held->errors.rmse);
  ASSERT_EQ(result.validation.size(), 1U);
  EXPECT_LT(result.validation[0].above_10_soc.mean_error_percent, 1.0);
  ASSERT_EQ(result.constant_current.size(), 4U);
  for (std::size_t k = 0; k < 4; ++k) {
    const auto& log = result.constant_current[k];
    EXPECT_EQ(log.voltage.file, logs[k].entry.file);
    EXPECT_EQ(log.measured_s, result.discharge_times->rows[k].measured_s);
    EXPECT_EQ(log.current_A, result.discharge_times->rows[k].current_A);
    EXPECT_LT(log.voltage.above_10_soc.mean_error_percent, 1.0);
    // The times of the whole cell are nearer than those that know the diffusion alone.
    EXPECT_LT(log.error_percent, 1.0) << k;
  }
  // The curve of the low-rate log lies below v_oc by the ohmic drop.
  EXPECT_NEAR(result.low_rate_offset_V, 0.05 * (0.1314 + 0.03), 0.2 * 0.05 * 0.16);
  EXPECT_LT(result.cell.open_circuit_voltage(0.5), truth.open_circuit_voltage(0.5));
}

TEST(StagedRun, TakesTheLowRateChargeForAlphaWithoutTwoCurrents) {
  const Cell truth = Truth();
  const StagedResult result =
      Identify({ConstantCurrent(truth, 1.0), LowRate(truth), Pulses(truth)});
  EXPECT_EQ(result.alpha_source, "low-rate-charge");
  EXPECT_EQ(AlphaSourceInWords(result.alpha_source), "the charge of the low-rate log");
  EXPECT_FALSE(result.discharge_times.has_value());
  EXPECT_EQ(result.alpha_C, result.low_rate_charge_C);
  EXPECT_TRUE(
      OneSays(result.done_instead, "constant currents that do not differ: alpha is the charge"));
  EXPECT_LT(result.pulses.errors.mean_error_percent, kMethodErrorPercent);
}

TEST(StagedRun, TakesTheNominalCapacityForAlphaWhenNothingElseTells) {
  const Cell truth = Truth();
  StagedGiven given;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  const StagedResult result = Identify({Pulses(truth)}, given);
  EXPECT_EQ(result.alpha_source, "nominal-capacity");
  EXPECT_EQ(result.alpha_C, 2160.0);
  EXPECT_TRUE(OneSays(result.done_instead, "--alpha-C gives a better one"));
  EXPECT_FALSE(result.open_circuit_voltage.has_value());
}

TEST(StagedRun, TakesTheCurveAndAlphaFromPulsesWithoutALowRateLog) {
  const Cell truth = Truth();
  const StagedResult result = Identify({ConstantCurrent(truth, 1.0), Pulses(truth)});
  EXPECT_TRUE(result.converged);
  ASSERT_TRUE(result.from_rests.has_value());
  EXPECT_FALSE(result.open_circuit_voltage.has_value());
  EXPECT_EQ(result.alpha_source, "pulse-charge");
  // The pulses end at the cut-off under 6C, so that nearly a quarter of the charge stays.
  EXPECT_LT(result.alpha_C, truth.diffusion->alpha_C);
  EXPECT_GT(result.alpha_C, 0.75 * truth.diffusion->alpha_C);
  EXPECT_TRUE(OneSays(result.done_instead, "alpha is the charge of the pulses until cut-off"));
  EXPECT_TRUE(OneSays(result.done_instead, "no low-rate log: v_oc(A) joins the voltages"));
  // Every rest lies on the true curve, on the axis of the alpha that was taken.
  for (const SettledRest& rest : result.from_rests->rests) {
    const double soc = 1.0 - (1.0 - rest.soc) * result.alpha_C / truth.diffusion->alpha_C;
    EXPECT_NEAR(result.cell.open_circuit_voltage(rest.soc), truth.open_circuit_voltage(soc), 1e-9);
  }
  const Json stage = StagedToJson(result).at("stages").at("open_circuit_voltage");
  EXPECT_EQ(stage.at("source"), "rests");
  EXPECT_EQ(stage.at("rest_count"), result.from_rests->rests.size());
  EXPECT_EQ(stage.at("rests").size(), result.from_rests->rests.size());
  for (const char* key : {"largest_drift_V", "soc_lo", "soc_hi", "guessed_to_soc", "half_gap_V"})
    EXPECT_TRUE(stage.at(key).is_number()) << key;
}

TEST(StagedRun, ANominalCapacityServesWhereThePulsesEndAboveTheCutOff) {
  const Cell truth = Truth();
  LoadedLog pulses = Pulses(truth);
  for (auto* column :
       {&pulses.log.record.time_s, &pulses.log.record.current_A, &pulses.log.record.voltage_V}) {
    column->resize(10000);
  }
  const StagedResult result = Identify({pulses});
  EXPECT_EQ(result.alpha_source, "nominal-capacity");
  ASSERT_TRUE(result.from_rests.has_value());
  EXPECT_FALSE(result.from_rests->guessed_to_soc);  // the log ends with a rest
}

TEST(StagedRun, UsesConstantCurrentsWithoutPulsesAndCallsTheAnswerWeak) {
  const Cell truth = Truth();
  const StagedResult result =
      Identify({ConstantCurrent(truth, 1.0), ConstantCurrent(truth, 3.0), LowRate(truth)});
  EXPECT_EQ(result.fitted_kind, LogKind::kConstantCurrent);
  EXPECT_TRUE(
      OneSays(result.done_instead, "no pulses log: stage 3 uses the constant-current logs"));
  EXPECT_TRUE(OneSays(result.cautions, "take them as weak"));
  EXPECT_LT(result.pulses.errors.mean_error_percent, 0.5);
}

TEST(StagedRun, NamesABranchThatIsNotThere) {
  Cell truth = Truth();
  truth.branches.clear();
  StagedGiven given;
  given.alpha_C = truth.diffusion->alpha_C;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  const StagedResult result = Identify({Pulses(truth)}, given);
  EXPECT_TRUE(OneSays(result.cautions, "branch 1 was not found"));
  EXPECT_NEAR(result.cell.series_resistance_Ohm.resistance_Ohm[0] / 0.1314, 1.0, 1e-4);
}

TEST(StagedRun, PlainEquivalentCircuitHasNoDiffusionInItsCellFile) {
  Cell truth = Truth();
  truth.diffusion.reset();
  truth.capacity_Ah = 1353.6 / 3600.0;
  StagedGiven given;
  given.alpha_C = 1353.6;
  given.open_circuit_voltage = truth.open_circuit_voltage;
  StagedOptions options;
  options.pulses.diffusion = false;
  const StagedResult result = Identify({Pulses(truth)}, given, options);
  EXPECT_FALSE(result.cell.diffusion.has_value());
  EXPECT_FALSE(result.pulses_beta_held.has_value());
  EXPECT_NEAR(result.cell.alpha_C(), 1353.6, 1e-9);
  EXPECT_NEAR(result.cell.branches[0].resistance_Ohm.resistance_Ohm[0] / 0.03, 1.0, kExactRelative);
  EXPECT_NEAR(*result.cell.branches[0].capacitance_F / 1500.0, 1.0, kExactRelative);
}

TEST(StagedRun, RefusesAConstantCurrentLogThatEndsEarly) {
  const Cell truth = Truth();
  LoadedLog early = ConstantCurrent(truth, 1.0);
  for (auto* column :
       {&early.log.record.time_s, &early.log.record.current_A, &early.log.record.voltage_V}) {
    column->resize(600);
  }
  const std::vector<LoadedLog> logs{
      early, ConstantCurrent(truth, 2.0), LowRate(truth), Pulses(truth)};
  try {
    static_cast<void>(Identify(logs));
    FAIL() << "expected a LoadError";
  } catch (const LoadError& error) {
    EXPECT_TRUE(OneSays({error.what()}, "cc_1C.csv:")) << error.what();
    EXPECT_FALSE(OneSays({error.what()}, "cc_2C.csv")) << error.what();
  }
}

TEST(StagedRun, SummaryHasTheKeysOfTheContract) {
  const Cell truth = Truth();
  const Json json = StagedToJson(Identify(
      {ConstantCurrent(truth, 1.0), ConstantCurrent(truth, 2.0), LowRate(truth), Pulses(truth)}));
  const Json& times = json.at("stages").at("discharge_times");
  for (const char* key : {"alpha_C",
                          "beta_per_sqrt_s",
                          "alpha_standard_error_C",
                          "beta_standard_error_per_sqrt_s",
                          "identifiable",
                          "beta_lower_bound_per_sqrt_s"}) {
    EXPECT_TRUE(times.contains(key)) << key;
  }
  ASSERT_EQ(times.at("logs").size(), 2U);
  for (const char* key : {"file", "current_A", "measured_s", "predicted_s", "error_percent"}) {
    EXPECT_TRUE(times.at("logs")[0].contains(key)) << key;
  }
  EXPECT_EQ(json.at("stages").at("open_circuit_voltage").at("source"), "low-rate");
  for (const char* key : {"method", "mean_error_percent", "max_error_percent", "rmse_V"}) {
    EXPECT_TRUE(json.at("stages").at("open_circuit_voltage").contains(key)) << key;
  }
  for (const char* stage : {"pulses_beta_held", "pulses"}) {
    for (const char* key : {"optimizer",
                            "mean_error_percent",
                            "max_error_percent",
                            "rmse_V",
                            "evaluations",
                            "termination",
                            "wall_s",
                            "at_bound"}) {
      EXPECT_TRUE(json.at("stages").at(stage).contains(key)) << stage << " " << key;
    }
  }
  EXPECT_TRUE(json.at("validation").is_array());
  ASSERT_EQ(json.at("constant_current").size(), 2U);
  for (const char* key : {"file",
                          "current_A",
                          "measured_s",
                          "predicted_s",
                          "error_percent",
                          "mean_error_percent",
                          "max_error_percent",
                          "rmse_V",
                          "mean_error_percent_above_10_soc",
                          "rmse_V_above_10_soc"}) {
    EXPECT_TRUE(json.at("constant_current")[1].at(key).is_number() || key == std::string("file"))
        << key;
  }
  EXPECT_TRUE(ConstantCurrentErrorsToJson({}).at("predicted_s").is_null());
  EXPECT_TRUE(ConstantCurrentErrorsToJson({}).at("error_percent").is_null());
}

StagedResult IdentifyLab(const std::string& file) {
  const Campaign campaign = ReadCampaign(file);
  return IdentifyStaged(campaign, LoadCampaign(campaign));
}

// Numbers of an independent implementation (NumPy, tests/reference/reference_cell.py, backward
// hold, M = 10 with tail, one branch, v_oc through every row of the low-rate log); tolerances are a
// unit of its last digit or, where the curve's nodes matter, the change that 200 nodes instead of
// all rows make there.
TEST(StagedRun, NissanLeafAsAnIndependentImplementationFoundIt) {
  const auto file = test::LabDataPath("nissan_leaf_33ah/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const StagedResult result = IdentifyLab(file);
  EXPECT_NEAR(result.discharge_times->alpha_C, 111739.59, 0.01);
  EXPECT_NEAR(result.discharge_times->beta_per_sqrt_s, 0.204303, 1e-6);
  EXPECT_NEAR(result.discharge_times->alpha_standard_error_C, 1272.69, 0.01);
  EXPECT_NEAR(result.discharge_times->beta_standard_error_per_sqrt_s, 0.036308, 1e-6);
  EXPECT_NEAR(result.pulses.parameters.beta_per_sqrt_s, 0.26883, 5e-4);
  EXPECT_NEAR(result.pulses.parameters.series_resistance_Ohm, 1.2818e-3, 1e-6);
  EXPECT_TRUE(OneSays(result.pulses.at_bound, "r_1"));  // its branch vanishes
  EXPECT_LE(result.pulses.errors.mean_error_percent, 0.22);
}

TEST(StagedRun, DmegcAsAnIndependentImplementationFoundIt) {
  const auto file = test::LabDataPath("dmegc_inr18650_26_r1/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const StagedResult result = IdentifyLab(file);
  // There the last row ended a discharge; here the crossing of the cut-off, up to 0.1 mV and 0.07 s
  // before it.
  EXPECT_NEAR(result.discharge_times->alpha_C, 9353.887, 0.05);
  EXPECT_TRUE(OneSays(result.pulses.at_bound, "beta"));
  EXPECT_EQ(result.pulses.parameters.beta_per_sqrt_s, 1.0);
  EXPECT_NEAR(result.pulses.parameters.time_constant_s[0], 66.2, 0.3);
  EXPECT_LE(result.pulses.errors.mean_error_percent, 0.19);
  EXPECT_LE(result.pulses.errors.rmse, 8.68e-3);
  ASSERT_EQ(result.validation.size(), 1U);
  EXPECT_NEAR(result.validation[0].all.mean_error_percent, 1.034, 0.01);
}

TEST(StagedRun, LgM50SaysThatBetaIsNotIdentifiable) {
  const auto file = test::LabDataPath("lg_m50_5ah/campaign.toml");
  LIPOID_SKIP_WITHOUT(file);
  const StagedResult result = IdentifyLab(file);
  EXPECT_FALSE(result.discharge_times->identifiable);
  EXPECT_TRUE(OneSays({result.discharge_times->reason},
                      "the delivered charge does not fall with the current"));
  EXPECT_GT(result.discharge_times->beta_lower_bound_per_sqrt_s, 0.0);
  EXPECT_TRUE(OneSays(result.done_instead, "stage 3 starts at"));
  const Json json = StagedToJson(result);
  EXPECT_TRUE(json.at("stages").at("discharge_times").at("beta_per_sqrt_s").is_null());
}

// A constant current that ended early has no say in alpha where its weight is small.
TEST(StagedRun, TheWeightOfALogCountsInStage1) {
  const Cell truth = Truth();
  Cell lesser = truth;
  lesser.diffusion->alpha_C *= 0.9;
  std::vector<LoadedLog> logs{ConstantCurrent(truth, 1.0),
                              ConstantCurrent(truth, 2.0),
                              ConstantCurrent(lesser, 3.0),
                              LowRate(truth),
                              Pulses(truth)};
  const double even_C = Identify(logs).alpha_C;
  logs[2].entry.weight = 1e-6;
  const double weighted_C = Identify(logs).alpha_C;
  const double without_C = Identify({logs[0], logs[1], logs[3], logs[4]}).alpha_C;
  EXPECT_NEAR(weighted_C / without_C, 1.0, 1e-5);
  EXPECT_GT(std::abs(even_C / without_C - 1.0), 1e-3);
}

// From every start of the search the second branch ends without resistance, where its time constant is nowhere and
// no step leads on. At 9 s it has a part in the answer.
TEST(StagedRun, LooksForABranchThatIsGoneAtEveryTimeConstant) {
  const Campaign campaign =
      ReadCampaign(test::SourcePath("fixtures/lab/dmegc_inr18650_26_r1/campaign.toml"));
  const auto logs = LoadCampaign(campaign);
  StagedOptions options;
  options.pulses.branches = 2;
  const auto fit = IdentifyStaged(campaign, logs, options).pulses;
  StagedGiven given;
  given.parameters.start["tau_2"] = 8.6;
  const auto from_there = IdentifyStaged(campaign, logs, options, given).pulses;
  EXPECT_NEAR(fit.errors.rmse, from_there.errors.rmse, 1e-9);
  EXPECT_NEAR(fit.parameters.resistance_Ohm[0], 0.0078, 2e-4);
  EXPECT_NEAR(fit.parameters.time_constant_s[0], 8.6, 0.1);
}

}  // namespace
}  // namespace lipoid
