// Falls of the voltage after steps of the current.
#include "identify/trust/edges.h"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "identify/synthesis/protocols.h"
#include "identify/validation.h"
#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "model/statistics/normal_noise.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

constexpr double kMeasured_Ohm = 0.05;
constexpr double kPredicted_Ohm = 0.06;

// Rows of a resistance under these steps, {duration, current}, backward hold, and of another one.
std::vector<Edge> EdgesOfSteps(const std::vector<std::pair<double, double>>& steps,
                               double sampling_s,
                               double current_noise_A = 0.0) {
  EdgeFinder finder;
  NormalNoise normal(1, 0);
  double time_s = 0.0;
  finder.Add(0.0, 0.0, 4.0, 4.0, 0.8);
  for (const auto& [duration_s, current_A] : steps) {
    for (double t = sampling_s; t <= duration_s + 1e-9; t += sampling_s) {
      time_s += sampling_s;
      const double i = current_A + current_noise_A * normal();
      finder.Add(time_s, i, 4.0 - kMeasured_Ohm * current_A, 4.0 - kPredicted_Ohm * current_A, 0.8);
    }
  }
  return finder.edges();
}

TEST(Edges, OfAResistanceAreTheResistance) {
  const auto edges = EdgesOfSteps({{20.0, 0.0}, {40.0, 2.0}, {40.0, 0.0}}, 1.0);
  ASSERT_EQ(edges.size(), 6U);  // on and off, after 1, 10 and 30 s
  for (std::size_t k = 0; k < edges.size(); ++k) {
    EXPECT_EQ(edges[k].after_s, kAfterEdge_s[k % 3]);
    EXPECT_NEAR(edges[k].measured_Ohm, kMeasured_Ohm, 1e-14);
    EXPECT_NEAR(edges[k].predicted_Ohm, kPredicted_Ohm, 1e-14);
    EXPECT_EQ(edges[k].soc, 0.8);
  }
  // A noise of the sensor that is small against its levels makes no steps of its own.
  EXPECT_EQ(EdgesOfSteps({{20.0, 0.0}, {40.0, 2.0}, {40.0, 0.0}}, 1.0, 0.01).size(), 6U);
}

TEST(Edges, AreThoseThatTheRowsShow) {
  // Rows every 10 s show nothing of a second; a pulse of 12 s ends before 30 s have passed.
  const auto slow = EdgesOfSteps({{20.0, 0.0}, {40.0, 2.0}}, 10.0);
  ASSERT_EQ(slow.size(), 2U);
  EXPECT_EQ(slow[0].after_s, 10.0);
  EXPECT_EQ(slow[1].after_s, 30.0);
  EXPECT_EQ(EdgesOfSteps({{20.0, 0.0}, {12.0, 2.0}}, 1.0).size(), 2U);
}

TEST(Edges, NeedAHeldLevelBeforeALargeStepAndAFallAboveTheResolution) {
  EXPECT_TRUE(EdgesOfSteps({{20.0, 0.0}, {3.0, 2.0}, {3.0, 1.0}, {3.0, 2.0}}, 3.0).size() <= 1U);
  EXPECT_TRUE(EdgesOfSteps({{2.0, 0.0}, {2.0, 2.0}, {2.0, 1.0}, {2.0, 2.0}}, 1.0).empty());
  // The step from 2 to 2.2 A is small; 0.1 A times 50 mOhm are 5 mV.
  EXPECT_EQ(EdgesOfSteps({{20.0, 0.0}, {40.0, 2.0}, {40.0, 2.2}}, 1.0).size(), 3U);
  EXPECT_TRUE(EdgesOfSteps({{20.0, 0.0}, {40.0, 0.1}}, 1.0).empty());
}

// 60,000 steps over the charge: what is kept does not grow with the log, and shows all of it.
TEST(Edges, OfALongLogAreFewAndFromAllOfIt) {
  constexpr int kSteps = 60'000;
  EdgeFinder finder;
  double time_s = 0.0;
  for (int step = 0; step < kSteps; ++step) {
    const double current_A = step % 2 == 0 ? 0.0 : 2.0;
    const double soc = 1.0 - static_cast<double>(step) / kSteps;
    for (int row = 0; row < 11; ++row) {
      time_s += 1.0;
      finder.Add(time_s,
                 current_A,
                 4.0 - kMeasured_Ohm * current_A,
                 4.0 - kPredicted_Ohm * current_A,
                 soc);
    }
  }
  EXPECT_LE(finder.edges().size(), kMostEdges);
  EXPECT_GE(finder.edges().size(), kMostEdges / 3);
  const auto groups = GroupEdges(finder.edges());
  ASSERT_EQ(groups.size(), 6U);  // after 1 and 10 s, in thirds
  const double tenths = static_cast<double>(finder.edges().size()) / 20.0;  // of each of both times
  for (const EdgeGroup& group : groups) {
    EXPECT_NEAR(static_cast<double>(group.edges), 3.0 * tenths, 3.0);
    EXPECT_NEAR(group.ratio, kPredicted_Ohm / kMeasured_Ohm, 1e-12);
  }
}

TEST(Edges, AreComparedByTimeAndThirdsOfTheCharge) {
  std::vector<Edge> edges;
  for (const double ratio : {1.0, 1.3, 5.0}) edges.push_back({0.5, 10.0, 0.05, 0.05 * ratio});
  edges.push_back({0.5, 1.0, 0.05, 0.05});   // one of this time
  edges.push_back({0.05, 10.0, 0.05, 0.5});  // near empty
  edges.push_back({1.0, 10.0, 0.05, 0.05});
  edges.push_back({0.7, 10.0, 0.05, 0.05});
  edges.push_back({0.8, 10.0, 0.05, 0.05});
  const auto groups = GroupEdges(edges);
  ASSERT_EQ(groups.size(), 2U);
  EXPECT_EQ(groups[0].low_soc, 0.4);
  EXPECT_EQ(groups[0].edges, 3U);
  EXPECT_NEAR(groups[0].ratio, 1.3, 1e-12);
  EXPECT_NEAR(groups[1].ratio, 1.0, 1e-12);
  EXPECT_EQ(
      DoubtAboutEdges(groups),
      "10 s after steps of the current the logs show 50 mOhm and this cell 65 (+30 % step by step, in the "
      "median of 3 steps "
      "between 40 and 70 % of the charge)");
  EXPECT_EQ(EdgesToJson(groups)[0].at("cell_Ohm"), groups[0].predicted_Ohm);
  EXPECT_EQ(DoubtAboutEdges({groups[1]}), "");
  EXPECT_EQ(DoubtAboutEdges({}), "");
}

// The error of all rows hardly moves where r_s is far too large, for most rows are at rest.
TEST(Edges, OfAnotherCellAreOff) {
  const Cell truth = LoadCell("gifi-600mAh-1");
  std::vector<test::CurrentStep> steps{{60.0, 0.0}};
  for (int k = 0; k < 12; ++k) {
    steps.push_back({60.0, 1.2});
    steps.push_back({1800.0, 0.0});
  }
  Record record = test::RecordOfSteps(steps);
  record.voltage_V = Predict(truth, record.time_s, record.current_A).voltage_V;
  const auto doubt = [&](const Cell& cell) {
    const LogErrors errors = Validate(cell, record);
    EXPECT_LT(errors.all.mean_error_percent, 1.0);
    return DoubtAboutEdges(GroupEdges(errors.edges));
  };
  EXPECT_EQ(doubt(truth), "");
  Cell other = truth;
  for (double& r : other.series_resistance_Ohm.resistance_Ohm) r *= 1.4;
  EXPECT_NE(doubt(other).find("+"), std::string::npos) << doubt(other);
}

}  // namespace
}  // namespace lipoid
