#include "identify/identification.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "identify/logs/plausibility.h"
#include "identify/validation.h"
#include "model/battery/cell_file.h"
#include "model/battery/cell_parameters.h"
#include "model/core/errors.h"
#include "tests/support/synthetic_campaign.h"
#include "tests/support/throws.h"

namespace lipoid {
namespace {

using test::Truth;

TEST(Identification, HasTheSameShapeForEitherMethod) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  logs[0].log.report.current_sign_is_of_others = true;
  const Campaign campaign = test::CampaignOf(logs);
  for (const auto method : {IdentifyMethod::kStaged, IdentifyMethod::kJoint}) {
    const Identification found = Identify(campaign, logs, {.method = method, .profiled = {"beta"}});
    EXPECT_TRUE(found.converged);
    EXPECT_EQ(found.staged.has_value(), method == IdentifyMethod::kStaged);
    EXPECT_EQ(found.joint.has_value(), method == IdentifyMethod::kJoint);
    // The staged method takes the low-rate voltage for v_oc: some percent off.
    EXPECT_NEAR(*CellParameter(found.cell, "beta"), 0.1924, 0.01);
    EXPECT_EQ(found.trust.quantities.front().name, "alpha");
    ASSERT_TRUE(found.cell.uncertainty.has_value());
    EXPECT_TRUE(found.cell.uncertainty->soc_follows_alpha);
    EXPECT_NO_THROW((void)ParseCell(CellToJson(found.cell).dump(), "cell.json"));
    ASSERT_EQ(found.profiles.size(), 1U);
    EXPECT_EQ(found.profiles[0].estimate, *CellParameter(found.cell, "beta"));
    // The mean error is that of the logs it says it used.
    double sum = 0.0;
    int count = 0;
    for (const LoadedLog& log : logs) {
      const auto kinds = found.fitted_kinds();
      if (std::find(kinds.begin(), kinds.end(), log.entry.kind) == kinds.end()) continue;
      sum += Validate(found.cell, log).all.mean_error_percent;
      ++count;
    }
    EXPECT_NEAR(found.mean_error_percent(), sum / count, 1e-9);
    const Json json = IdentificationToJson(found);
    for (const char* key : {"method",
                            "converged",
                            "alpha_C",
                            "parameters",
                            "trust",
                            "stages",
                            "validation",
                            "constant_current",
                            "cautions",
                            "profiles",
                            "not_drawn"})
      EXPECT_TRUE(json.contains(key)) << key;
    EXPECT_EQ(json.at("log_notes").size(), 1U);
  }
}

// A log of a cell with 5 % more voltage took no part, and the first line says nothing of it.
TEST(Identification, SaysThatOtherLogsAreDescribedFarWorse) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  for (const double factor : {1.0, 1.05}) {
    LoadedLog other = logs.back();
    other.entry.kind = LogKind::kValidation;
    other.entry.path = other.entry.file = "other.csv";
    for (double& voltage_V : other.log.record.voltage_V) voltage_V *= factor;
    auto all = logs;
    all.push_back(other);
    for (const auto method : {IdentifyMethod::kStaged, IdentifyMethod::kJoint}) {
      const auto notes = Identify(test::CampaignOf(all), all, {.method = method}).log_notes;
      const std::string begin = "the validation logs are predicted to ";
      const auto note = std::find_if(notes.begin(), notes.end(), [&](const std::string& each) {
        return each.starts_with(begin);
      });
      ASSERT_EQ(note != notes.end(), factor > 1.0);
      // 1 - 1/1.05 = 4.76 % beside what the fit itself leaves.
      if (factor > 1.0) {
        EXPECT_NEAR(std::stod(note->substr(begin.size())), 4.76, 0.3);
      }
    }
  }
}

// A late current shows loaded rows at rest; a late voltage says nothing of a start, and a wrong one is said beside it.
TEST(Identification, OnlyALateCurrentSilencesTheDoubtAboutAStart) {
  for (const bool current : {false, true}) {
    auto logs = test::SyntheticLogs(Truth(), 2.0, 0.0002);
    logs[0].entry.initial_soc = 0.7;
    Record& pulses = logs[4].log.record;
    Column& late = current ? pulses.current_A : pulses.voltage_V;
    for (std::size_t k = late.size() - 1; k > 0; --k) late[k] = std::as_const(late)[k - 1];
    EXPECT_NE(DoubtAboutLag(pulses), "");
    const auto notes = Identify(test::CampaignOf(logs), logs, {}).log_notes;
    const bool said = std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.starts_with("cc_1C.csv rests at 4.2 V before its first load");
    });
    EXPECT_EQ(said, !current);
  }
}

TEST(Identification, SaysThatTheTemperatureOfAValidationLogChangesNothing) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  for (LoadedLog& log : logs) log.entry.ambient_degC = 25.0;
  LoadedLog cold = logs.back();
  cold.entry.kind = LogKind::kValidation;
  cold.entry.path = cold.entry.file = "cold.csv";
  logs.push_back(cold);
  const auto said = [&] {
    const auto notes = Identify(test::CampaignOf(logs), logs, {}).log_notes;
    return std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
      return note.starts_with(
          "cold.csv: ambient_degC and initial_degC say nothing of a validation log here");
    });
  };
  EXPECT_FALSE(said()) << "it is that of the other logs";
  logs.back().entry.ambient_degC = 0.0;
  EXPECT_TRUE(said());
}

// The staged method made one cell of pulses at -10 and 25 degC, "good", and said nothing.
TEST(Identification, TheStagedMethodDoubtsLogsOfSeveralTemperatures) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  const auto reasons = [&](IdentifyMethod method) {
    return Identify(test::CampaignOf(logs), logs, {.method = method}).quality.reasons;
  };
  EXPECT_EQ(reasons(IdentifyMethod::kStaged), std::vector<std::string>{});
  for (LoadedLog& log : logs) log.entry.ambient_degC = 25.0;
  logs.back().entry.ambient_degC = 16.0;
  EXPECT_EQ(reasons(IdentifyMethod::kStaged), std::vector<std::string>{});
  logs.back().entry.ambient_degC = 14.0;
  const auto doubted = reasons(IdentifyMethod::kStaged);
  ASSERT_EQ(doubted.size(), 1U);
  EXPECT_TRUE(
      doubted[0].starts_with("the logs begin between 14 and 25 degC, and the staged method"));
  EXPECT_EQ(reasons(IdentifyMethod::kJoint), std::vector<std::string>{});
}

// A voltage that was clipped at 4.096 V made beta 0.214 (0.209 to 0.219) of 0.25, "good".
// Of ten campaigns of pulses alone each had a beta far outside its interval.
TEST(Identification, TheStagedMethodDoubtsWhatStandsInForALogThatIsNotThere) {
  const auto all = test::SyntheticLogs(test::Truth(), 5.0, 0.0002);
  const auto verdict_of = [](const std::vector<LoadedLog>& logs) {
    return Identify(test::CampaignOf(logs), logs, {.method = IdentifyMethod::kStaged}).Verdict();
  };
  EXPECT_NE(verdict_of(all).find(": good"), std::string::npos);
  const std::string pulses = verdict_of({all[4]});
  EXPECT_NE(pulses.find("v_oc(A) is that of rests, without a low-rate log: beta and the "
                        "branches may lie far outside their intervals"),
            std::string::npos)
      << pulses;
  const std::string discharges = verdict_of({all[0], all[1], all[2], all[3]});
  EXPECT_NE(discharges.find("fair: there were discharges for stage 3, and no pulses: beta and"),
            std::string::npos)
      << discharges;
}

TEST(Identification, DoubtsLogsWhoseVoltageWasNotMeasured) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  logs[0].log.report.stuck_voltage = logs[1].log.report.stuck_voltage = "as reading found";
  const FitQuality quality =
      Identify(test::CampaignOf(logs), logs, {.method = IdentifyMethod::kStaged}).quality;
  EXPECT_EQ(quality.grade, FitGrade::kFair);
  EXPECT_EQ(quality.reasons,
            std::vector<std::string>{fmt::format(
                "the voltage of {}, {} was not measured throughout, as their warnings say",
                logs[0].entry.file,
                logs[1].entry.file)});
}

// The right logs were accused of a wrong start of the one that v_oc(A) comes from.
TEST(Identification, SaysWhichStartsContradictOneAnother) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  const auto low = std::find_if(logs.begin(), logs.end(), [](const LoadedLog& log) {
    return log.entry.kind == LogKind::kLowRate;
  });
  ASSERT_NE(low, logs.end());
  low->entry.initial_soc = 0.85;
  const auto notes = Identify(test::CampaignOf(logs), logs, {}).log_notes;
  const std::string said = fmt::format(
      "V before its first load, as {} does, and the one starts at a state of charge of 1 and the other at 0.85: one of "
      "the two initial_soc is wrong; the starts of ",
      low->entry.file);
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [&](const std::string& note) {
    return note.find(said) != std::string::npos;
  })) << fmt::format("{}", fmt::join(notes, "\n"));
}

// A bound within a thousandth of the estimate, but several standard errors away, made it "at-bound"; and intervals went
// on beyond bounds.
TEST(Identification, ABoundBesideAnEstimateIsTheEndOfItsIntervalAlone) {
  const auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  for (const IdentifyMethod method : {IdentifyMethod::kStaged, IdentifyMethod::kJoint}) {
    const auto beta = [&](const std::map<std::string, std::pair<double, double>>& bounds) {
      IdentifyOptions options{.method = method};
      options.given.parameters.bounds = bounds;
      return *FindQuantity(Identify(test::CampaignOf(logs), logs, options).trust, "beta");
    };
    const QuantityTrust open = beta({});
    const double bound = open.estimate + 0.5 * open.standard_error;
    EXPECT_GT(bound, (1.0 + 5e-6) * open.estimate);  // a search stops within a millionth
    const QuantityTrust beside = beta({{"beta", {0.5 * open.estimate, bound}}});
    EXPECT_NE(beside.verdict, Verdict::kAtBound);
    EXPECT_NEAR(beside.estimate, open.estimate, 0.49 * open.standard_error);
    EXPECT_EQ(beside.high, bound);
    EXPECT_LT(beside.low, open.estimate);
    EXPECT_EQ(beta({{"beta", {0.5 * open.estimate, 0.97 * open.estimate}}}).verdict,
              Verdict::kAtBound);
  }
}

TEST(Identification, AnEndBeforeConvergenceStandsInTheFirstLine) {
  const auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  IdentifyOptions options{.method = IdentifyMethod::kStaged};
  options.staged.solver.max_iterations = 1;
  const Identification found = Identify(test::CampaignOf(logs), logs, options);
  EXPECT_FALSE(found.converged);
  EXPECT_NE(found.quality.Sentence("its own logs").find("the search ended before it had converged"),
            std::string::npos);
}

TEST(Identification, SaysThatDischargesAreNotOfOneCell) {
  auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  Cell aged = Truth();
  aged.diffusion->alpha_C *= 0.85;
  LoadedLog other = test::SyntheticLogs(aged, 5.0, 0.0002)[0];
  other.entry.file = "aged_1C.csv";
  logs.push_back(other);
  const auto notes = Identify(test::CampaignOf(logs), logs, {}).log_notes;
  EXPECT_TRUE(std::any_of(notes.begin(), notes.end(), [](const std::string& note) {
    return note.starts_with("at 0.6 A cc_1C.csv delivers ") &&
           note.find(" Ah until the cut-off and aged_1C.csv ") != std::string::npos;
  }));
}

TEST(Identification, RefusesAProfileBeforeItReadsAnything) {
  EXPECT_EQ(test::MessageOf<OptionError>([] {
              CheckIdentifyOptions({.method = IdentifyMethod::kJoint, .profiled = {"alpha"}});
            }),
            "option --profile: alpha is a convention of the joint method and moves no voltage; see "
            "its interval in the report");
  EXPECT_EQ(test::MessageOf<OptionError>([] {
              CheckIdentifyOptions({.method = IdentifyMethod::kStaged, .profiled = {"r_9"}});
            }),
            "option --profile: no parameter 'r_9' in this fit; profiles can be had of beta, r_s, "
            "r_1, tau_1, c_1");
}

}  // namespace
}  // namespace lipoid
