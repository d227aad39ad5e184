#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/studies/study.h"
#include "model/core/errors.h"
#include "tests/identify/studies/study_logs.h"

namespace lipoid {
namespace {

using test::KnownCampaign;
using test::NoProgress;
using test::PulseLog;
using test::StudyCell;

// The logs of a cell with as many modes as are studied.
const StudyResult& OfHundredModes() {
  static const StudyResult study = [] {
    const Cell truth = StudyCell({{0.03, 300.0}}, 100);
    const KnownCampaign known(truth, {PulseLog(truth)});
    return StudyTerms(known.Input(), NoProgress);
  }();
  return study;
}

const Json& Row(int terms, bool tail) {
  for (const auto& row : OfHundredModes().rows) {
    if (row.at("terms") == terms && row.at("tail") == tail) return row;
  }
  throw std::runtime_error("no such row");
}
double Number(int terms, bool tail, const char* key) { return Row(terms, tail).at(key); }

TEST(StudyTerms, WithTheTailTenModesAreAsGoodAsAHundred) {
  // Ten modes leave 1/(b² 11²) = 0.2 s to the tail, below the sampling of 1 s; what is left of it
  // after a row, e^-4.5, is far below a thousandth of the noise.
  for (const int terms : {10, 20, 50}) {
    EXPECT_NEAR(Number(terms, true, "beta_bias_percent"), 0.0, 0.01) << terms;
    EXPECT_NEAR(Number(terms, true, "series_resistance_bias_Ohm"), 0.0, 1e-5) << terms;
    EXPECT_NEAR(Number(terms, true, "rmse_V"), Number(100, true, "rmse_V"), 1e-7) << terms;
  }
  EXPECT_NEAR(Number(100, true, "beta_per_sqrt_s"), 0.1924, 0.002);
  EXPECT_NEAR(Number(100, true, "series_resistance_Ohm"), 0.1314, 0.0005);
}

TEST(StudyTerms, WithoutItWhatIsLostLooksLikeAResistance) {
  // Ever less with more modes, but a hundred still leave some.
  double before = 1.0;
  for (const int terms : {5, 10, 20, 50, 100}) {
    const double bias_Ohm = Number(terms, false, "series_resistance_bias_Ohm");
    EXPECT_GT(bias_Ohm, 0.0) << terms;
    EXPECT_LT(bias_Ohm, before) << terms;
    EXPECT_LT(Number(terms, false, "beta_bias_percent"), 0.0) << terms;
    EXPECT_GT(Number(terms, false, "rmse_V"), Number(terms, true, "rmse_V")) << terms;
    before = bias_Ohm;
  }
}

TEST(StudyTerms, TheLostShareIsThatOfTheSum) {
  const double pi = std::acos(-1.0);
  double kept = 0.0;
  int m = 0;
  for (const int terms : {1, 2, 3, 5, 10, 20, 50, 100}) {
    while (m < terms) {
      ++m;
      kept += 1.0 / (m * m);
    }
    const double lost_percent = 100.0 * (1.0 - kept / (pi * pi / 6.0));
    EXPECT_NEAR(Number(terms, false, "lost_share_percent"), lost_percent, 1e-10) << terms;
    EXPECT_EQ(Number(terms, true, "lost_share_percent"), 0.0) << terms;
  }
  EXPECT_NEAR(Number(10, false, "lost_share_percent"), 5.8, 0.05);  // docs/corrections.md
}

// As good as no diffusion: no number of modes says anything of beta.
TEST(StudyTerms, SaysThatABetaAtItsBoundIsOffByNothing) {
  Cell truth = StudyCell({{0.03, 45.0}});
  truth.diffusion->beta_per_sqrt_s = 5.0;
  const KnownCampaign known(truth, {PulseLog(truth)});
  const StudyResult study = StudyTerms(known.Input(), NoProgress);
  EXPECT_EQ(study.columns.back().key, "at_bound");
  EXPECT_EQ(study.rows[7].at("terms"), 100);
  EXPECT_EQ(study.rows[7].at("at_bound")[0], "beta");
  EXPECT_TRUE(study.remarks.back().starts_with(
      "beta is at its bound of 1 s^-1/2 in the fit that the others are compared with"))
      << study.remarks.back();
  EXPECT_EQ(OfHundredModes().remarks.size(), 1U);
  EXPECT_EQ(OfHundredModes().facts.at("converged"), true);
}

TEST(StudyTerms, NeedsTheDiffusion) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign known(truth, {PulseLog(truth)});
  known.options.pulses.diffusion = false;
  EXPECT_THROW(static_cast<void>(StudyTerms(known.Input(), NoProgress)), OptionError);
}

TEST(StudyTerms, RefusesANumberOfTerms) {
  const Cell truth = StudyCell({{0.03, 45.0}});
  KnownCampaign terms(truth, {PulseLog(truth)});
  terms.options.pulses.terms = 3;
  EXPECT_THROW(static_cast<void>(StudyTerms(terms.Input(), NoProgress)), OptionError);
  KnownCampaign tail(truth, {PulseLog(truth)});
  tail.options.pulses.tail = !tail.options.pulses.tail;
  EXPECT_THROW(static_cast<void>(StudyTerms(tail.Input(), NoProgress)), OptionError);
}

}  // namespace
}  // namespace lipoid
