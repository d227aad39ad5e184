// Hysteresis, the offset of the current sensor and a free alpha, as the joint estimator sees them.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "identify/joint/joint_run.h"
#include "identify/joint/joint_trust.h"
#include "identify/trust/profile.h"
#include "model/battery/cell_file.h"
#include "tests/support/joint_example.h"
#include "tests/support/paths.h"
#include "tests/support/ridders.h"
#include "tests/support/synthetic_campaign.h"

namespace lipoid {
namespace {

using test::JointExample;
using test::SetupOf;
using test::UnknownsOf;

// A cell with hysteresis beside every term that an offset of the current moves, its tables on the
// nodes of the structure; and what its sensor shows too much.
JointExample ExampleWithHysteresis() {
  JointExample e = test::ExampleOfTables();
  test::AddSelfHeating(e);
  e.structure.hysteresis_soc = {0.1, 0.5, 0.9};
  e.structure.current_offset = e.structure.free_alpha = true;
  e.rates.hysteresis_folds = 25.0;
  e.rates.current_offset_A = 0.004;
  e.rates.alpha_C = e.cell.alpha_C();
  e.cell.hysteresis = Cell::Hysteresis{25.0, e.structure.hysteresis_soc, {0.05, 0.02, 0.03}};
  return e;
}

// One log with both directions and rests, that starts at 0.7.
LoadedLog BothDirections(LogKind kind = LogKind::kPulses) {
  Record record;
  record.file = "both.csv";
  for (int k = 0; k < 900; ++k) {
    record.time_s.push_back(10.0 * k);
    const int phase = k % 60;
    record.current_A.push_back(k == 0 || phase >= 40 ? 0.0 : phase < 25 ? 0.9 : -1.1);
  }
  LoadedLog log = test::AsLog(kind, std::move(record));
  log.entry.initial_soc = 0.7;
  return log;
}

// What the sensor shows is what flowed and its offset, but for open circuits.
void Shift(Record& record, double offset_A) {
  for (double& current_A : record.current_A) {
    if (current_A != 0.0) current_A += offset_A;
  }
}

TEST(JointHysteresis, RowsAreThoseOfTheCellModel) {
  const JointExample e = ExampleWithHysteresis();
  LoadedLog log = BothDirections();
  Record& r = log.log.record;
  r.voltage_V = Predict(e.cell, r.time_s, r.current_A, r.hold, 0.7).voltage_V;
  Shift(r, e.rates.current_offset_A);
  const JointSetup setup = SetupOf(e.cell);
  const JointLogs joint =
      MakeJointLogs(std::vector{log}, setup.alpha_C, setup.open_circuit_voltage, {});
  const JointObservations seen(joint, setup);
  const auto rows = seen.Rows(e.structure, e.rates, UnknownsOf(e, joint.typical_A));
  // Rounding of sums of some ten terms of 4 V.
  EXPECT_LT(rows[0].residual_V.cwiseAbs().maxCoeff(), 1e-12);
}

// The slopes of the rows against differences of the voltage of the cell that simulations step.
TEST(JointHysteresis, SlopesAreThoseOfRiddersDifferences) {
  const JointExample e = ExampleWithHysteresis();
  LoadedLog log = BothDirections();
  Record& r = log.log.record;
  r.voltage_V = Predict(e.cell, r.time_s, r.current_A, r.hold, 0.7).voltage_V;
  const std::vector<double> flowed_A = r.current_A.ToVector();
  Shift(r, e.rates.current_offset_A);
  const JointSetup setup = SetupOf(e.cell);
  const JointLogs joint =
      MakeJointLogs(std::vector{log}, setup.alpha_C, setup.open_circuit_voltage, {});
  const JointObservations seen(joint, setup);
  const auto rows =
      seen.Rows(e.structure, e.rates, UnknownsOf(e, joint.typical_A), CurveSlope::kOfSegments);
  const RateSlots slots(e.structure);
  ASSERT_EQ(slots.size(), 8);

  const auto voltage = [&](std::size_t row, double folds, double offset_A, double alpha_C) {
    Cell cell = e.cell;
    cell.hysteresis->folds = folds;
    std::vector<double> current_A = flowed_A;
    for (std::size_t k = 0; k < current_A.size(); ++k) {
      if (current_A[k] != 0.0) current_A[k] += e.rates.current_offset_A - offset_A;
    }
    const double soc = 1.0 - 0.3 * alpha_C / cell.alpha_C();
    return Predict(cell, r.time_s, current_A, r.hold, soc).voltage_V[row];
  };
  const double alpha_C = e.cell.alpha_C();
  const double offset_A = e.rates.current_offset_A;
  for (const std::size_t row : {35U, 130U, 455U, 899U}) {
    struct Checked {
      const char* name;
      int slot;
      test::RiddersDerivative expected;
    };
    // Steps so short that no row crosses a node of a table.
    for (const Checked& one :
         {Checked{"gamma",
                  slots.hysteresis(),
                  test::Ridders(
                      [&](double x) { return voltage(row, x, offset_A, alpha_C); }, 25.0, 2.0)},
          Checked{"i_off",
                  slots.offset(),
                  test::Ridders(
                      [&](double x) { return voltage(row, 25.0, x, alpha_C); }, offset_A, 1e-5)},
          Checked{"alpha",
                  slots.alpha(),
                  test::Ridders(
                      [&](double x) { return voltage(row, 25.0, offset_A, x); }, alpha_C, 0.1)}}) {
      const double slope = rows[0].sensitivity(static_cast<Eigen::Index>(row), one.slot);
      const double tolerance = 1e-6 * std::abs(one.expected.value) + 10.0 * one.expected.error;
      EXPECT_NEAR(slope, one.expected.value, tolerance) << one.name << " at row " << row;
      EXPECT_NE(slope, 0.0) << one.name;
    }
  }
}

// A lab that charges and discharges slowly, with pulses and a fast discharge: everything that it
// takes to tell hysteresis, the capacity and the offset of the sensor apart.
std::vector<LoadedLog> BothWays(const Cell& truth,
                                double noise_V,
                                double offset_A,
                                std::uint64_t seed) {
  auto logs = test::SyntheticLogs(truth, 20.0, noise_V, 10 * seed);
  Record charge;
  charge.file = "low_rate_charge.csv";
  for (int k = 0; k * 100.0 < 12.0 * 3600.0; ++k) {
    charge.time_s.push_back(k * 100.0);
    charge.current_A.push_back(k == 0 ? 0.0 : -truth.capacity_Ah / 12.0);
  }
  const Prediction at = Predict(truth, charge.time_s, charge.current_A, charge.hold, 0.0);
  std::size_t rows = 0;
  while (rows < charge.size() && at.soc[rows] < 0.97) ++rows;
  charge.voltage_V = at.voltage_V;
  for (auto* column : {&charge.time_s, &charge.current_A, &charge.voltage_V}) column->resize(rows);
  std::mt19937_64 engine(10 * seed + 7);
  std::normal_distribution<double> noise(0.0, noise_V);
  for (double& v : charge.voltage_V) v += noise(engine);
  LoadedLog log = test::AsLog(LogKind::kLowRateCharge, std::move(charge));
  log.entry.initial_soc = 0.0;
  logs.push_back(std::move(log));
  for (LoadedLog& one : logs) Shift(one.log.record, offset_A);
  return logs;
}

using test::kJointNoise_V;
const JointOptions kQuick{.branches = 1,
                          .resistance_nodes = 1,
                          .self_heating = Presence::kOff,
                          .charge_transfer = Presence::kOff};

// Twenty campaigns: each new parameter is found, and its 95 % interval holds the truth as often as it
// says. Of 20 trials each at 95 % fewer than 16 happen once in four hundred.
TEST(JointHysteresis, FindsWhatIsThereWithinItsInterval) {
  Cell truth = test::Truth();
  truth.hysteresis = Cell::Hysteresis{40.0, {}, {0.02}};
  constexpr double kOffset_A = 0.0015;  // 3 % of the slow current
  constexpr int kCampaigns = 20;
  constexpr int kLeast = 16;
  struct Tally {
    const char* name;
    double truth;
    double closeness;  // an interval must not be wide
    int covered = 0;
  };
  std::vector<Tally> tallies{
      {"gamma", 40.0, 8.0}, {"M", 0.02, 0.001}, {"i_off", kOffset_A, 1e-4}, {"alpha", 1353.6, 5.0}};
  for (std::uint64_t seed = 1; seed <= kCampaigns; ++seed) {
    const auto logs = BothWays(truth, kJointNoise_V, kOffset_A, seed);
    const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, kQuick);
    ASSERT_TRUE(result.cell.hysteresis) << seed;
    ASSERT_TRUE(result.choice.best.structure.current_offset) << seed;
    EXPECT_EQ(result.alpha_source, "least-squares");
    const TrustReport trust = AssessJoint(result);
    for (Tally& tally : tallies) {
      const QuantityTrust* found = FindQuantity(trust, tally.name);
      if (found == nullptr) continue;
      const double off = std::abs(found->estimate - tally.truth);
      if (off <= Reach95(*found)) ++tally.covered;
      EXPECT_LE(off, tally.closeness) << tally.name << " " << seed;
    }
  }
  for (const Tally& tally : tallies) {
    EXPECT_GE(tally.covered, kLeast) << tally.name;
    fmt::print("{}: {} of {} intervals cover the truth\n", tally.name, tally.covered, kCampaigns);
  }
}

// A sensor that shows too little on the way out makes the cell look smaller, and its alpha must not be taken
// from where the last slope of such a curve reaches the cut-off.
TEST(JointHysteresis, FindsAnOffsetOfEitherSign) {
  Cell truth = test::Truth();
  truth.hysteresis = Cell::Hysteresis{40.0, {}, {0.02}};
  for (const double offset_A : {-0.003, -0.002, 0.003}) {  // 6 and 4 % of the slow current
    const auto logs = BothWays(truth, kJointNoise_V, offset_A, 5);
    const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, kQuick);
    EXPECT_EQ(result.alpha_source, "least-squares") << offset_A;
    ASSERT_TRUE(result.choice.best.structure.current_offset) << offset_A;
    EXPECT_NEAR(result.choice.best.rates.current_offset_A, offset_A, 1e-4);
    EXPECT_NEAR(result.alpha_C, 1353.6, 5.0) << offset_A;
  }
}

TEST(JointHysteresis, IsNotFoundWhereThereIsNone) {
  int found = 0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const auto logs = BothWays(test::Truth(), kJointNoise_V, 0.0, seed);
    const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, kQuick);
    const JointStructure& structure = result.choice.best.structure;
    if (!structure.hysteresis_soc.empty() || structure.current_offset) ++found;
  }
  EXPECT_EQ(found, 0);
}

TEST(JointHysteresis, DischargesAloneDoNotAskForIt) {
  Cell truth = test::Truth();
  truth.hysteresis = Cell::Hysteresis{40.0, {}, {0.02}};
  const auto logs = test::SyntheticLogs(truth, 20.0, kJointNoise_V);
  const JointResult result = IdentifyJoint(test::CampaignOf(logs), logs, {}, kQuick);
  EXPECT_FALSE(result.cell.hysteresis);
  for (const auto& row : result.choice.tried)
    EXPECT_TRUE(row.solution.structure.hysteresis_soc.empty()) << row.what;
}

// The loop that the found cell makes encloses the energy that its equation says.
TEST(JointHysteresis, AreaOfTheFoundLoopIsThatOfTheTruth) {
  Cell truth = test::Truth();
  truth.hysteresis = Cell::Hysteresis{40.0, {}, {0.02}};
  const auto logs = BothWays(truth, kJointNoise_V, 0.0, 3);
  const Cell found = IdentifyJoint(test::CampaignOf(logs), logs, {}, kQuick).cell;
  ASSERT_TRUE(found.hysteresis);
  const double charge_C = 0.5 * truth.alpha_C();
  const auto area_J = [&](const Cell& cell) {
    const CellModel<double> model(cell.Parameters());
    auto state = model.Relaxed(0.8);
    const auto step = model.MakeStep(1.0);
    double area = 0.0;
    for (int half = 0; half < 6; ++half) {
      const double sign = half % 2 == 0 ? 1.0 : -1.0;
      if (half == 4) area = 0.0;  // the loop is closed
      for (int k = 0; k < 5000; ++k) {
        const double soc = 1.0 - state.delivered_C / cell.alpha_C();
        area -= model.BesideTheCurve(state, soc) * sign * charge_C / 5000;
        model.Advance(state, sign * charge_C / 5000, step);
      }
    }
    return area;
  };
  const double q = 40.0 * 0.5;
  const double expected_J =
      2.0 * 0.02 * (charge_C - 2.0 * std::tanh(0.5 * q) * truth.alpha_C() / 40.0);
  EXPECT_NEAR(area_J(truth), expected_J, 5e-3 * expected_J);  // rectangles of 1/250 e-fold
  EXPECT_NEAR(area_J(found), expected_J, 0.05 * expected_J);
}

// C/20 out and in of a real cell, as its cycler logged them (2.997 Ah, 2.616 Ah): 9.2 mA make the two
// agree, says the README of the data.
TEST(JointHysteresis, FindsTheOffsetOfACycler) {
  const auto of = [](const char* file) {
    return test::LabDataPath(std::string("panasonic_18650pf/t25/") + file);
  };
  const auto pulses = of("pulse.csv");
  LIPOID_SKIP_WITHOUT(pulses);
  Campaign campaign;
  campaign.name = "panasonic";
  campaign.capacity_Ah = 2.9;
  campaign.cutoff_V = 2.5;
  AddLogs(campaign, LogKind::kConstantCurrent, {of("cc_1c.csv")}, {});
  AddLogs(campaign, LogKind::kLowRate, {of("low_rate.csv")}, {});
  AddLogs(campaign, LogKind::kPulses, {pulses}, {});
  CampaignLog charge = campaign.logs[1];
  charge.kind = LogKind::kLowRateCharge;
  charge.file = charge.path = of("low_rate_charge.csv");
  charge.initial_soc = 0.0;
  campaign.logs.push_back(charge);
  JointOptions options = kQuick;
  options.resistance_nodes = 13;
  const JointResult result = IdentifyJoint(campaign, LoadCampaign(campaign), {}, options);
  ASSERT_TRUE(result.choice.best.structure.current_offset);
  EXPECT_NEAR(result.choice.best.rates.current_offset_A, 9.2e-3, 3e-3);
  EXPECT_NEAR(result.alpha_C / 3600.0, 2.81, 0.03 * 2.81);
  ASSERT_TRUE(result.cell.hysteresis);
  // Charge less discharge is 37 to 50 mV, with the drop of C/20 both ways in it.
  const double both_V = 2.0 * result.cell.hysteresis->Voltage(0.5, 1.0);
  EXPECT_GT(both_V, 0.01);
  EXPECT_LT(both_V, 0.05);
}

}  // namespace
}  // namespace lipoid
