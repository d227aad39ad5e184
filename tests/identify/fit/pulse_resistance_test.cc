#include "identify/fit/pulse_resistance.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "identify/identification.h"
#include "identify/logs/load_campaign.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "tests/support/paths.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::Truth;

// What the cell file itself says when it is simulated: rest, then a current for so long, in fine steps,
// since tables are taken at the steps.
double Simulated(const Cell& cell, const PulseResistance& asked) {
  const int steps = static_cast<int>(asked.after_s / 0.05);
  std::vector<double> time_s{0.0};
  for (int k = 1; k <= steps; ++k) time_s.push_back(asked.after_s * k / steps);
  std::vector<double> current_A(time_s.size(), asked.current_A);
  current_A[0] = 0.0;
  const auto voltage_V = Predict(cell, time_s, current_A, Hold::kBackward, asked.soc).voltage_V;
  return (voltage_V.front() - voltage_V.back()) / asked.current_A;
}

TEST(PulseResistance, IsThatOfTheCellFileByEitherMethod) {
  const auto logs = test::SyntheticLogs(Truth(), 5.0, 0.0002);
  const Campaign campaign = test::CampaignOf(logs);
  for (const auto method : {IdentifyMethod::kStaged, IdentifyMethod::kJoint}) {
    const Identification found = Identify(campaign, logs, {.method = method});
    ASSERT_EQ(found.trust.resistance.size(), 3U);
    double before_Ohm = 0.0;
    for (const PulseResistance& r : found.trust.resistance) {
      EXPECT_EQ(r.soc, 0.5);
      // The last word on alpha moves the nodes by less than a part in a hundred thousand.
      EXPECT_NEAR(r.resistance_Ohm, Simulated(found.cell, r), 1e-4 * r.resistance_Ohm);
      EXPECT_GT(r.resistance_Ohm, before_Ohm);
      before_Ohm = r.resistance_Ohm;
      EXPECT_LT(r.low_Ohm, r.resistance_Ohm);
      EXPECT_LT(r.high_Ohm, 1.1 * r.resistance_Ohm);
    }
  }
}

// Near half charge the tables of this cell bend: within 30 s of 1C its R(30 s) moves by 1.4 %.
TEST(PulseResistance, FollowsTablesThatBend) {
  const Campaign campaign = ReadCampaign(test::LabDataPath("nissan_leaf_33ah/campaign.toml"));
  const auto logs = LoadCampaign(campaign);
  const Identification found = Identify(campaign,
                                        logs,
                                        {.method = IdentifyMethod::kJoint,
                                         .joint = {.branches = 1,
                                                   .resistance_nodes = 34,
                                                   .self_heating = Presence::kOff,
                                                   .charge_transfer = Presence::kOff}});
  ASSERT_EQ(found.trust.resistance.size(), 3U);
  for (const PulseResistance& r : found.trust.resistance)
    EXPECT_NEAR(r.resistance_Ohm, Simulated(found.cell, r), 1e-3 * r.resistance_Ohm) << r.after_s;
}

// Where logs do not start full alpha is an unknown of its own, and half charge is half of it.
TEST(PulseResistance, IsThatOfTheCellFileWhereAlphaIsSearched) {
  const Cell truth = Truth();
  auto logs = test::SyntheticLogs(truth, 5.0, 0.0);
  for (LoadedLog& log : logs) {
    if (log.entry.kind != LogKind::kPulses) continue;
    Record& r = log.log.record;
    log.entry.initial_soc = 0.9;
    const auto from_part = Predict(truth, r.time_s, r.current_A, r.hold, 0.9);
    std::size_t rows = 0;
    while (rows < r.size() && from_part.voltage_V[rows] > truth.cutoff_V) ++rows;
    r.voltage_V = from_part.voltage_V;
    for (auto* column : {&r.time_s, &r.current_A, &r.voltage_V}) column->resize(rows);
  }
  // A charge of the low rate that is 3 % off is what makes alpha worth a search.
  for (LoadedLog& log : logs) {
    if (log.entry.kind == LogKind::kLowRate) log.entry.initial_soc = 0.97;
  }
  const Identification found =
      Identify(test::CampaignOf(logs), logs, {.method = IdentifyMethod::kJoint});
  ASSERT_EQ(found.joint->alpha_source, "least-squares");
  ASSERT_EQ(found.trust.resistance.size(), 3U);
  EXPECT_GT(std::abs(found.joint->alpha_C / found.joint->setup.alpha_C - 1.0), 1e-4);
  for (const PulseResistance& r : found.trust.resistance)
    EXPECT_NEAR(r.resistance_Ohm, Simulated(found.cell, r), 1e-4 * r.resistance_Ohm) << r.after_s;
}

// Ten modes of a slow diffusion, and rows that see the next of 1.1 s at its steady value alone: the resistance after
// 1 s comes out too large, and says that it is known no better.
TEST(PulseResistance, OfASecondIsDoubtedWhereFasterModesAreStillMoving) {
  Cell truth = Truth();
  truth.diffusion->beta_per_sqrt_s = 0.085;
  truth.diffusion->terms = 200;
  const auto logs = test::SyntheticLogs(truth, 10.0, 0.0002);
  const Identification found =
      Identify(test::CampaignOf(logs), logs, {.method = IdentifyMethod::kJoint});
  ASSERT_EQ(found.trust.resistance.size(), 3U);
  for (const PulseResistance& r : found.trust.resistance) {
    const double is_Ohm = Simulated(truth, r);
    EXPECT_LE(r.low_Ohm, is_Ohm) << r.after_s;
    EXPECT_GE(r.high_Ohm, is_Ohm) << r.after_s;
    if (r.after_s > 1.0) {
      EXPECT_LT(r.high_Ohm, 1.05 * r.low_Ohm) << r.after_s;
    }
  }
  const auto& said = found.joint->cautions;
  EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const std::string& one) {
    return one.find("is slower than the resistance after 1 s asks for") != std::string::npos;
  }));
}

// Each coloured noise its own: 40 campaigns, three intervals each, those of one campaign alike.
TEST(PulseResistance, IntervalsHoldTheTruth) {
  const Cell truth = Truth();
  const auto clean = test::SyntheticLogs(truth, 10.0);
  constexpr int kSeeds = 40;
  int held = 0;
  double widest = 0.0;
  for (int seed = 1; seed <= kSeeds; ++seed) {
    auto logs = clean;
    test::AddColouredNoise(logs, 0.0002, 0.0004, static_cast<std::uint64_t>(seed));
    const Identification found = Identify(test::CampaignOf(logs),
                                          logs,
                                          {.method = IdentifyMethod::kJoint,
                                           .joint = {.branches = 1,
                                                     .resistance_nodes = 1,
                                                     .self_heating = Presence::kOff,
                                                     .charge_transfer = Presence::kOff}});
    for (const PulseResistance& r : found.trust.resistance) {
      const double is_Ohm = Simulated(truth, r);
      held += r.low_Ohm <= is_Ohm && is_Ohm <= r.high_Ohm ? 1 : 0;
      widest = std::max(widest, (r.high_Ohm - r.low_Ohm) / is_Ohm);
    }
  }
  EXPECT_GE(held, 0.86 * 3 * kSeeds);  // 95 %, less three standard deviations of 40 campaigns
  EXPECT_LT(widest, 0.1);              // and they say something
}

TEST(ExpectedError, IsThatOfALogThatTookNoPart) {
  const auto logs = test::SyntheticLogs(Truth(), 5.0, 0.001);
  for (const auto method : {IdentifyMethod::kStaged, IdentifyMethod::kJoint}) {
    const Identification found = Identify(test::CampaignOf(logs), logs, {.method = method});
    // Few unknowns and many rows: a new log is hardly harder than those that were fitted. The
    // low-rate log is never left out, and the ends of discharges are not.
    EXPECT_NEAR(found.expected_error.percent / found.mean_error_percent(), 1.0, 0.2);
    EXPECT_LT(found.expected_error.low_percent, found.expected_error.percent);
    EXPECT_GT(found.expected_error.high_percent, found.expected_error.percent);
  }
}

}  // namespace
}  // namespace lipoid
