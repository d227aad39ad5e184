#include "identify/joint/joint_choice.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "identify/joint/joint_run.h"
#include "model/battery/cell_file.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::kJointNoise_V;

using test::Truth;

JointResult Identify(const Cell& truth, const JointOptions& options = {}) {
  const auto logs = test::SyntheticLogs(truth, 5.0, kJointNoise_V);
  return IdentifyJoint(test::CampaignOf(logs), logs, {}, options);
}

TEST(JointChoice, TakesTheSimplestStructureWhereNothingRicherIsThere) {
  const JointStructure structure = Identify(Truth()).choice.best.structure;
  EXPECT_EQ(structure.nodes(), 1);
  EXPECT_EQ(structure.branches, 1);
  EXPECT_FALSE(structure.self_heating);
  EXPECT_FALSE(structure.charge_transfer);
}

// Noise that lasts for minutes looks like a structure to rows beside it, and like nothing to other
// logs: with discharges at four currents each is left out whole, with fewer a fifth of one at a time.
// Chance asks for one of half a dozen structures in one campaign of eight, for more than two in one run
// of a hundred. Three discharges, one of ten minutes, tell less: five of the eight are found constant.
TEST(JointChoice, SlowNoiseIsNoStructure) {
  for (const bool four_currents : {true, false}) {
    const Cell truth = Truth();
    int simple = 0;
    for (std::uint64_t seed = 1; seed <= 8; ++seed) {
      auto logs = test::SyntheticLogs(truth, 5.0);
      if (four_currents) {
        logs.push_back(
            test::AsLog(LogKind::kConstantCurrent,
                        test::SimulateLog(
                            truth, 5.0, 7200.0, [](double) { return 1.2; }, "cc_2C.csv")));
      }
      test::AddColouredNoise(logs, 0.0002, 0.0005, seed);
      const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
      const JointStructure& s = result.choice.best.structure;
      if (s.nodes() == 1 && s.branches == 1 && !s.self_heating && !s.charge_transfer) ++simple;
    }
    EXPECT_GE(simple, four_currents ? 6 : 4);
    fmt::print("{} of 8 found constant, with one branch\n", simple);
  }
}

TEST(JointChoice, TakesTablesWhereResistancesRiseTowardsEmpty) {
  Cell truth = Truth();
  truth.series_resistance_Ohm = {{0.0, 0.1, 0.3, 1.0}, {0.3, 0.2, 0.14, 0.13}};
  const JointResult result = Identify(truth);
  EXPECT_GT(result.choice.best.structure.nodes(), 1);
  for (const double a : {0.1, 0.3, 0.6, 0.9}) {
    EXPECT_NEAR(result.cell.series_resistance_Ohm(a), truth.series_resistance_Ohm(a), 0.005)
        << "at " << a;
  }
}

// Every fit begins with one branch, and a cell that has none is found to have none. Who asks for one
// branch (--branches 1) gets one.
TEST(JointChoice, FindsThatThereIsNoBranch) {
  Cell truth = Truth();
  truth.branches.clear();
  for (const double noise_V : {0.0, kJointNoise_V}) {
    const auto logs = test::SyntheticLogs(truth, 5.0, noise_V);
    const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
    EXPECT_TRUE(result.cell.branches.empty()) << noise_V;
    EXPECT_NEAR(result.cell.series_resistance_Ohm(0.5), truth.series_resistance_Ohm(0.5), 2e-4);
    EXPECT_EQ(IdentifyJoint(test::CampaignOf(logs), logs, {}, {.branches = 1}).cell.branches.size(),
              1);
  }
}

// With one branch, tables and terms stand in for the second; beside the second nobody asks for them.
TEST(JointChoice, DropsWhatStoodInForABranch) {
  Cell truth = Truth();
  truth.branches.push_back(truth.branches.front());
  truth.branches[0].resistance_Ohm = truth.branches[1].resistance_Ohm = 0.05;
  truth.branches[0].time_constant_s = 20.0;
  truth.branches[1].time_constant_s = 400.0;
  for (Cell::Branch& branch : truth.branches)
    branch.capacitance_F = branch.time_constant_s / branch.resistance_Ohm.resistance_Ohm[0];
  const JointResult result = Identify(truth);
  const JointStructure& found = result.choice.best.structure;
  EXPECT_EQ(found.branches, 2);
  EXPECT_EQ(found.nodes(), 1);
  EXPECT_FALSE(found.charge_transfer || found.self_heating);
  EXPECT_GT(result.choice.tried[result.choice.taken - 1].solution.structure.nodes(), 1);
  ASSERT_EQ(result.cell.branches.size(), 2);
  EXPECT_NEAR(result.cell.branches[0].time_constant_s, 20.0, 2.0);
  EXPECT_NEAR(result.cell.branches[1].time_constant_s, 400.0, 40.0);
}

// Beside one branch charge transfer and self-heating follow what the second would say; beside two they
// are nothing, and a fit that holds nothing is not taken.
TEST(JointChoice, TermsThatAreGoneBesideANewBranchDoNotStopIt) {
  Cell truth = Truth();
  truth.branches.push_back(truth.branches.front());
  truth.branches[0].resistance_Ohm = 0.1;
  truth.branches[1].resistance_Ohm = 0.05;
  truth.branches[0].time_constant_s = 5.0;
  truth.branches[1].time_constant_s = 1000.0;
  for (Cell::Branch& branch : truth.branches)
    branch.capacitance_F = branch.time_constant_s / branch.resistance_Ohm.resistance_Ohm[0];
  auto logs = test::SyntheticLogs(truth, 2.0, kJointNoise_V);
  logs.resize(1);  // at 1C
  for (int rate = 2; rate <= 5; ++rate) {
    logs.push_back(test::AsLog(LogKind::kConstantCurrent,
                               test::SimulateLog(
                                   truth,
                                   2.0,
                                   3600.0,
                                   [&](double) { return rate * truth.capacity_Ah; },
                                   fmt::format("cc_{}C.csv", rate),
                                   kJointNoise_V,
                                   static_cast<std::uint64_t>(rate))));
  }
  for (LoadedLog& log : test::SyntheticLogs(truth, 2.0, kJointNoise_V)) {
    if (log.entry.kind != LogKind::kConstantCurrent) logs.push_back(std::move(log));
  }
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  const JointStructure& found = result.choice.best.structure;
  EXPECT_EQ(found.branches, 2);
  EXPECT_EQ(found.nodes(), 1);
  EXPECT_FALSE(found.charge_transfer || found.self_heating);
}

TEST(JointChoice, FindsSelfHeating) {
  Cell truth = Truth();
  truth.self_heating =
      Cell::SelfHeating{.time_constant_s = 300.0, .resistance_drop_Ohm_per_A2 = 3e-3};
  const JointResult result = Identify(truth);
  ASSERT_TRUE(result.cell.self_heating);
  EXPECT_FALSE(result.cell.charge_transfer);
  EXPECT_NEAR(result.cell.self_heating->time_constant_s, 300.0, 15.0);
  EXPECT_NEAR(result.cell.self_heating->resistance_drop_Ohm_per_A2, 3e-3, 1.5e-4);
}

TEST(JointChoice, FindsChargeTransfer) {
  Cell truth = Truth();
  truth.charge_transfer =
      Cell::ChargeTransfer{.current_A = 0.5, .resistance_Ohm = Resistance<double>(0.1)};
  const JointResult result = Identify(truth);
  ASSERT_TRUE(result.cell.charge_transfer);
  EXPECT_FALSE(result.cell.self_heating);
  EXPECT_NEAR(result.cell.charge_transfer->current_A, 0.5, 0.05);
  EXPECT_NEAR(result.cell.charge_transfer->resistance_Ohm(0.5), 0.1, 0.005);
}

// Low rate and pulses of one current, of a cell that heats itself: what its drop does with the current
// is not in these logs, and one more process in time would be taken for it.
TEST(JointChoice, LoadsOfOneCurrentAskForNothingThatGoesWithTheCurrent) {
  Cell truth = Truth();
  truth.self_heating =
      Cell::SelfHeating{.time_constant_s = 300.0, .resistance_drop_Ohm_per_A2 = 3e-3};
  auto logs = test::SyntheticLogs(truth, 5.0, kJointNoise_V);
  logs.erase(logs.begin(), logs.begin() + 3);
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs);
  EXPECT_FALSE(result.logs.several_currents);
  for (const TriedStructure& row : result.choice.tried) {
    EXPECT_FALSE(row.solution.structure.self_heating) << row.what;
    EXPECT_FALSE(row.solution.structure.charge_transfer) << row.what;
  }
  EXPECT_TRUE(std::any_of(result.cautions.begin(), result.cautions.end(), [](const auto& one) {
    return one.find("a load of another current is an extrapolation") != std::string::npos;
  }));
  JointOptions told;
  told.self_heating = Presence::kOn;
  EXPECT_TRUE(IdentifyJoint(test::CampaignOf(logs), logs, {}, told).cell.self_heating);
}

TEST(JointChoice, DoesWhatItIsTold) {
  const JointResult result = Identify(Truth(),
                                      {.branches = 2,
                                       .resistance_nodes = 6,
                                       .voltage_nodes = 40,
                                       .self_heating = Presence::kOff,
                                       .charge_transfer = Presence::kOn,
                                       .smoothness = 0.01});
  const JointSolution& best = result.choice.best;
  EXPECT_EQ(best.structure.branches, 2);
  EXPECT_EQ(best.structure.nodes(), 6);
  EXPECT_EQ(best.structure.voltage_soc.size(), 40U);
  EXPECT_TRUE(best.structure.charge_transfer);
  EXPECT_FALSE(best.structure.self_heating);
  EXPECT_EQ(best.smoothness, 0.01);
  EXPECT_EQ(result.choice.tried.size(), 1U);
}

TEST(JointChoice, OneRowOfTheTableIsTaken) {
  const auto tried = Identify(Truth()).choice.tried;
  EXPECT_EQ(std::count_if(tried.begin(), tried.end(), [](const auto& row) { return row.taken; }),
            1);
  EXPECT_GT(tried.size(), 6U);
}

TEST(JointChoice, NodesRiseAndKeepToTheirRange) {
  for (const int count : {1, 2, 3, 6, 10, 13, 20, 34, 60}) {
    const auto nodes = ResistanceNodes(count);
    EXPECT_EQ(static_cast<int>(nodes.size()), count);
    EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end(), std::less_equal<>()));
    EXPECT_GE(nodes.front(), 0.0);
    EXPECT_LE(nodes.back(), 1.0);
  }
  for (const int count : {0, 2, 5, 40, 200}) {
    const auto nodes = VoltageNodes(count);
    EXPECT_TRUE(std::is_sorted(nodes.begin(), nodes.end(), std::less_equal<>()));
    EXPECT_EQ(nodes.back(), 1.0);
  }
  // Near zero the axis stays; elsewhere it is stretched over what was reached.
  EXPECT_EQ(OnAxis({0.0, 0.5, 1.0}, 0.01), (std::vector<double>{0.0, 0.5, 1.0}));
  EXPECT_EQ(OnAxis({0.0, 0.5, 1.0}, 0.5), (std::vector<double>{0.5, 0.75, 1.0}));
}

}  // namespace
}  // namespace lipoid
