#include "identify/joint/joint_log.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>
#include <vector>

#include "model/battery/cell_file.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

OpenCircuitVoltage Flat() { return OpenCircuitVoltage::Linear({0.0, 1.0}, {3.7, 3.7}); }

double Sum(const std::vector<double>& values) {
  return std::accumulate(values.begin(), values.end(), 0.0);
}

double ChargeOf(const JointLog& log) {
  double charge_C = 0.0;
  for (std::size_t k = 1; k < log.size(); ++k)
    charge_C += log.step_A[k] * (log.time_s[k] - log.time_s[k - 1]);
  return charge_C;
}

TEST(JointLog, EveryLogCountsAsItsWeightSaysWhateverItsRows) {
  auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 2.0);
  logs[1].entry.weight = 3.0;
  const JointLogs joint = MakeJointLogs(logs, 1350.0, Flat(), {});
  ASSERT_EQ(joint.logs.size(), 5U);
  for (std::size_t l = 0; l < 5; ++l)
    EXPECT_NEAR(Sum(joint.logs[l].weight), l == 1 ? 3.0 : 1.0, 1e-12);
  EXPECT_DOUBLE_EQ(joint.weight_sum, 7.0);
  EXPECT_DOUBLE_EQ(joint.largest_A, 3.6);
}

TEST(JointLog, RowsWeighLessWhereTheCurveIsSteep) {
  const auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 2.0);
  const auto steep = OpenCircuitVoltage::Linear({0.0, 0.5, 1.0}, {3.0, 4.0, 4.0});  // 2 V, then 0
  const JointLogs joint = MakeJointLogs(
      logs, 1350.0, steep, {.charge_uncertainty = 0.002, .voltage_uncertainty_V = 0.001});
  const JointLog& log = joint.logs[0];
  // 2 V times 0.002 is four times the millivolt.
  EXPECT_NEAR(log.weight[log.size() - 2] / log.weight[1], 1.0 / 17.0, 1e-12);
}

// One that has no rows to fit is no log of the fit either, nor takes the temperature of another.
TEST(JointLog, TemperaturesGoToTheLogsThatTheyAreOf) {
  auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 2.0);
  for (std::size_t l = 0; l < logs.size(); ++l)
    logs[l].entry.ambient_degC = 10.0 * static_cast<double>(l);
  Record& one_row = logs[1].log.record;
  for (auto* column : {&one_row.time_s, &one_row.current_A, &one_row.voltage_V})
    *column = Column({1.0});
  const JointLogs joint = MakeJointLogs(logs, 1350.0, Flat(), {});
  ASSERT_EQ(joint.logs.size(), logs.size() - 1);
  for (LoadedLog& log : logs) *log.entry.ambient_degC += 1.0;
  const JointLogs warmer = AtTemperaturesOf(logs, joint);
  for (std::size_t l = 0; l < joint.logs.size(); ++l) {
    ASSERT_EQ(warmer.logs[l].temperature_K.size(), joint.logs[l].size());
    EXPECT_NEAR(warmer.logs[l].temperature_K[0], joint.logs[l].temperature_K[0] + 1.0, 1e-9) << l;
    // One length and one temperature: what depends on both is as little as what depends on one.
    EXPECT_EQ(warmer.logs[l].warm_steps.length_s.size(), joint.logs[l].steps.length_s.size());
  }
}

TEST(JointLog, ALongLogInFewPointsKeepsItsChargeAndItsRows) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  const auto logs = test::SyntheticLogs(cell, 0.1);
  const JointLogs joint = MakeJointLogs(logs, 1350.0, Flat(), {});
  for (std::size_t l = 0; l < logs.size(); ++l) {
    const JointLog& log = joint.logs[l];
    const Record& record = logs[l].log.record;
    EXPECT_EQ(log.rows, record.size());
    EXPECT_LT(log.size(), record.size() / 3) << log.file;
    EXPECT_NEAR(Sum(log.count), static_cast<double>(record.size()), 1e-6);
    EXPECT_NEAR(ChargeOf(log), DeliveredCharge(record).back(), 1e-6);
  }
}

TEST(JointLog, SeesTheNoiseOfTheInstrument) {
  // 6C every ten seconds falls 4 mV a row.
  const auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 10.0, 0.0002);
  // The least of five estimates, of which those of slow rows see some curvature too.
  EXPECT_NEAR(MakeJointLogs(logs, 1350.0, Flat(), {}).noise_V, 0.0002, 0.00003);
}

// Neighbouring rows of a coarse voltage are mostly equal, and yet each is off by up to half a step.
TEST(JointLog, SeesHowFarRowsScatterAboutTheirPoints) {
  constexpr double kStep_V = 1e-3;
  auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 0.1);
  for (LoadedLog& log : logs) {
    std::vector<double> voltage_V;
    for (const double v : log.log.record.voltage_V)
      voltage_V.push_back(kStep_V * std::round(v / kStep_V));
    log.log.record.voltage_V = voltage_V;
  }
  // Uniform over a step.
  const double expected_V = kStep_V / std::sqrt(12.0);
  for (const JointLog& log : MakeJointLogs(logs, 1350.0, Flat(), {}).logs) {
    if (log.kind == LogKind::kPulses) continue;  // at rest it stays within one step
    EXPECT_NEAR(log.scatter_V, expected_V, 0.05 * expected_V) << log.file;
    EXPECT_LT(log.noise_V, 0.5 * expected_V) << log.file;
  }
}

TEST(JointLog, ValidationTakesNoPart) {
  auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 10.0);
  logs[0].entry.kind = LogKind::kValidation;
  const JointLogs joint = MakeJointLogs(logs, 1350.0, Flat(), {});
  ASSERT_EQ(joint.logs.size(), 4U);
  EXPECT_EQ(joint.logs[0].file, "cc_3C.csv");
}

// Three constant currents, one of them left out whole at a time, and pulses in turns.
TEST(JointLog, PulsesAreLeftOutInTurnsAndUnitsHoldEveryRow) {
  const auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 2.0);
  const JointLogs joint = MakeJointLogs(logs, 1350.0, Flat(), {});
  EXPECT_EQ(joint.groups, 4 * 5);
  double weight = 0.0;
  for (const JointLog& log : joint.logs) {
    for (std::size_t k = 0; k < log.size(); ++k) {
      EXPECT_EQ(log.group[k] == JointLog::kAlways, log.unit[k] == JointLog::kAlways);
      if (log.group[k] != JointLog::kAlways) weight += log.weight[k];
    }
    if (log.kind != LogKind::kPulses) continue;
    const std::set<int> groups(log.group.begin(), log.group.end());
    EXPECT_EQ(groups.size(), 5U);
    // A pulse and its rest stay together: the unit changes where a pulse begins only.
    for (std::size_t k = 2; k < log.size(); ++k) {
      EXPECT_EQ(log.group[k] != log.group[k - 1], log.unit[k] != log.unit[k - 1]);
      if (log.unit[k] != log.unit[k - 1]) {
        EXPECT_EQ(log.current_A[k - 1], 0.0);
        EXPECT_GT(log.current_A[k], 0.0);
      }
    }
  }
  // Every row that can be left out counts in one unit.
  EXPECT_NEAR(std::accumulate(joint.unit_weight.begin(), joint.unit_weight.end(), 0.0),
              weight,
              1e-12 * weight);
}

TEST(JointLog, PiecesAndStretchesAreLeftOutInTurnsAndEndsNever) {
  auto logs = test::SyntheticLogs(LoadCell("gifi-600mAh-1"), 2.0);
  logs[0].entry.kind = LogKind::kValidation;
  const JointLogs joint = MakeJointLogs(logs, 1350.0, Flat(), {});
  EXPECT_EQ(joint.groups, 3 * 5);
  EXPECT_EQ(joint.stretches, 3 * 5);
  for (const JointLog& log : joint.logs) {
    if (log.kind == LogKind::kPulses) {
      EXPECT_EQ(log.stretch.back() - log.stretch.front(), log.group.back() - log.group.front());
    }
    if (log.kind != LogKind::kConstantCurrent) continue;
    // A stretch is left out in one piece: five in their order, the ends aside, of two units each.
    EXPECT_TRUE(std::is_sorted(
        log.stretch.begin() + 1,
        std::find(log.stretch.begin() + 1, log.stretch.end() - 1, JointLog::kAlways)));
    EXPECT_EQ(std::set<int>(log.stretch.begin(), log.stretch.end()).size(), 6U);
    EXPECT_EQ(std::set<int>(log.group.begin(), log.group.end()).size(), 6U);  // five, and the ends
    EXPECT_EQ(log.group.front(), JointLog::kAlways);
    EXPECT_EQ(log.group.back(), JointLog::kAlways);
  }
}

// Four currents: each discharge is one group but for its ends, and has as many units as in pieces.
TEST(JointLog, DischargesAtManyCurrentsAreLeftOutWhole) {
  const Cell cell = LoadCell("gifi-600mAh-1");
  auto logs = test::SyntheticLogs(cell, 2.0);
  const JointLogs pieces = MakeJointLogs(logs, 1350.0, Flat(), {});
  EXPECT_FALSE(pieces.whole);
  logs.push_back(test::AsLog(LogKind::kConstantCurrent,
                             test::SimulateLog(
                                 cell, 2.0, 7200.0, [](double) { return 1.2; }, "cc_2C.csv")));
  const JointLogs whole = MakeJointLogs(logs, 1350.0, Flat(), {});
  EXPECT_TRUE(whole.whole);
  EXPECT_EQ(whole.groups, 4 + 5);
  for (std::size_t l = 0; l < whole.logs.size(); ++l) {
    const JointLog& log = whole.logs[l];
    if (log.kind != LogKind::kConstantCurrent) continue;
    EXPECT_EQ(log.group.size(), log.stretch.size());
    EXPECT_EQ(std::set<int>(log.group.begin(), log.group.end()).size(), 2U);
    EXPECT_EQ(std::set<int>(log.stretch.begin(), log.stretch.end()).size(), 2U);
    EXPECT_EQ(std::set<int>(log.unit.begin(), log.unit.end()).size(), 11U);  // ten, and the ends
    EXPECT_EQ(log.group.front(), JointLog::kAlways);
    EXPECT_EQ(log.group.back(), JointLog::kAlways);
  }
  // The same current again is no fourth one.
  logs.back() = logs.front();
  EXPECT_FALSE(MakeJointLogs(logs, 1350.0, Flat(), {}).whole);
}

}  // namespace
}  // namespace lipoid
