#include "identify/stages/start_values.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "tests/support/synthetic_record.h"

namespace lipoid {
namespace {

Cell RcCell(double r_s, double r_1, double tau_s) {
  Cell cell;
  cell.capacity_Ah = 1.0;
  cell.series_resistance_Ohm = Resistance<double>(r_s);
  cell.branches.push_back(
      {.resistance_Ohm = Resistance<double>(r_1), .time_constant_s = tau_s, .capacitance_F = {}});
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.5, 4.1});
  return cell;
}

Cell ThesisCell() {
  Cell cell = RcCell(0.13, 0.03, 45.0);
  cell.diffusion = Cell::Diffusion{.alpha_C = 1353.6, .beta_per_sqrt_s = 0.19};
  return cell;
}

// 30 s at 3 A and 10 min of rest, again and again.
Record Pulses(double sampling_s, Hold hold = Hold::kBackward, int pulses = 6) {
  std::vector<test::CurrentStep> steps = {{20.0, 0.0, sampling_s}};
  for (int k = 0; k < pulses; ++k) {
    steps.push_back({30.0, 3.0, sampling_s});
    steps.push_back({600.0, 0.0, sampling_s});
  }
  return test::RecordOfSteps(steps, hold);
}

void Measure(const Cell& cell, Record& record) {
  record.voltage_V = Predict(cell, record.time_s, record.current_A, record.hold).voltage_V;
}

TEST(StartValues, ShowTheParametersOfAResistorCapacitorCell) {
  constexpr double kSampling_s = 0.1;
  constexpr double kTau_s = 45.0;
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    Record record = Pulses(kSampling_s, hold);
    Measure(RcCell(0.13, 0.03, kTau_s), record);
    const auto start = FindStartValues({&record});
    // Within one interval the branch adds at most r_1 dt/tau, and the charge dt/3600 s of 0.6 V per
    // 3 A.
    EXPECT_NEAR(start.series_resistance_Ohm,
                0.13,
                0.03 * kSampling_s / kTau_s + kSampling_s * 0.6 / 3600.0 + 1e-9);
    // 63.2 % of an exponential that 600 s have finished: one time constant, to a row.
    EXPECT_NEAR(start.relaxation_s, kTau_s, 2 * kSampling_s);
    // Charged for 30 s: 1 - e^{-30/45} of r_1.
    EXPECT_NEAR(start.relaxation_Ohm, 0.03 * (1.0 - std::exp(-30.0 / kTau_s)), 2e-4);
    EXPECT_NEAR(start.shortest_s, kSampling_s, 1e-9);
    EXPECT_NEAR(start.longest_s, 600.0, 1.0);
    EXPECT_EQ(start.edges, 12);
    EXPECT_EQ(start.relaxations, 6);
  }
}

TEST(StartValues, PreferTheStepsThatAreSampledQuickly) {
  // Half of the steps are seen 30 s later, when the branch has followed: they say 0.16 Ohm.
  Record record = test::RecordOfSteps({{20.0, 0.0, 0.1},
                                       {30.0, 3.0, 0.1},
                                       {600.0, 0.0, 0.1},
                                       {600.0, 3.0, 60.0},
                                       {600.0, 0.0, 60.0},
                                       {600.0, 3.0, 60.0},
                                       {600.0, 0.0, 60.0}});
  Measure(RcCell(0.13, 0.03, 5.0), record);
  EXPECT_NEAR(FindStartValues({&record}).series_resistance_Ohm, 0.13, 0.001);
}

TEST(StartValues, OfSeveralRecordsCountAll) {
  Record a = Pulses(1.0);
  Record b = Pulses(1.0, Hold::kBackward, 3);
  Measure(ThesisCell(), a);
  Measure(ThesisCell(), b);
  const auto both = FindStartValues({&a, &b});
  EXPECT_EQ(both.edges, 18);
  EXPECT_EQ(both.relaxations, 9);
  EXPECT_GT(both.series_resistance_Ohm, 0.13);  // diffusion in a second comes on top
  EXPECT_LT(both.series_resistance_Ohm, 0.20);
}

TEST(StartValues, AreNotNumbersWhereNothingShowsThem) {
  Record rest = test::RecordOfSteps({{600.0, 0.0, 10.0}});
  for (const auto& start : {FindStartValues({&rest}), FindStartValues({})}) {
    EXPECT_TRUE(std::isnan(start.series_resistance_Ohm));
    EXPECT_TRUE(std::isnan(start.relaxation_s));
    EXPECT_TRUE(std::isnan(start.relaxation_Ohm));
    EXPECT_EQ(start.edges, 0);
    EXPECT_EQ(start.relaxations, 0);
    EXPECT_GT(start.shortest_s, 0.0);
    EXPECT_GE(start.longest_s, 4.0 * start.shortest_s);
  }
  // One row, as a cut log may have.
  const Record one = {.file = "one.csv",
                      .time_s = {1.0},
                      .current_A = {0.5},
                      .voltage_V = {3.7},
                      .temperature_degC = {}};
  EXPECT_GT(FindStartValues({&one}).shortest_s, 0.0);
}

// The prediction on the rows that stayed is that of the whole record: a constant current over one
// long step is what it is over many short ones.
void ExpectSamePrediction(const Record& record, const ThinnedRecord& thinned, double tolerance_V) {
  const auto whole = Predict(ThesisCell(), record.time_s, record.current_A, record.hold);
  const auto part =
      Predict(ThesisCell(), thinned.record.time_s, thinned.record.current_A, record.hold);
  std::size_t at = 0;
  for (std::size_t k = 0; k < thinned.record.size(); ++k) {
    while (at < record.size() && record.time_s[at] != thinned.record.time_s[k]) ++at;
    ASSERT_LT(at, record.size()) << "a time that is none of the record's";
    EXPECT_EQ(thinned.record.voltage_V[k], record.voltage_V[at]);
    EXPECT_NEAR(part.voltage_V[k], whole.voltage_V[at], tolerance_V) << "row " << at;
  }
}

TEST(Thin, IsExactForLevels) {
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    // 0.1 s in the pulses and 1 s in the rests; and a taper in which every row is another current.
    std::vector<test::CurrentStep> steps = {{20.0, 0.0, 1.0}};
    for (int k = 0; k < 5; ++k) {
      steps.push_back({30.0, 3.0, 0.1});
      steps.push_back({10.0, -1.0, 0.1});
      steps.push_back({600.0, 0.0, 1.0});
    }
    for (int k = 0; k < 50; ++k) steps.push_back({1.0, 2.0 - 0.03 * k, 0.1});
    Record record = test::RecordOfSteps(steps, hold);
    Measure(ThesisCell(), record);
    for (const std::size_t most : {100U, 500U, 2000U}) {
      const auto thinned = Thin(record, most);
      // 5500 rows, of which 61 change the level: each needs a row or two, whatever is asked for.
      EXPECT_LE(thinned.record.size(), std::max<std::size_t>(most, 200)) << most;
      EXPECT_EQ(std::accumulate(thinned.row_weight.begin(), thinned.row_weight.end(), 0.0),
                static_cast<double>(record.size()));
      EXPECT_EQ(thinned.record.hold, hold);
      EXPECT_EQ(thinned.record.time_s.back(), record.time_s.back());
      // The charge is summed in another order: rounding of 5500 rows over a slope of 0.6 V, and r_s
      // times it.
      ExpectSamePrediction(record, thinned, 1e-11);
    }
  }
}

TEST(Thin, KeepsAShortRecordAsItIs) {
  Record record = Pulses(10.0);
  Measure(ThesisCell(), record);
  const auto thinned = Thin(record, record.size());
  EXPECT_LE(thinned.record.size(), record.size());
  ExpectSamePrediction(record, thinned, 1e-11);
  const Record empty;
  EXPECT_EQ(Thin(empty, 100).record.size(), 0U);
  EXPECT_THROW(static_cast<void>(Thin(record, 1)), PreconditionError);
}

TEST(Thin, KeepsQuickRowsAfterASwitch) {
  // Geometric steps: the first seconds of a relaxation keep what shows a branch of 1 s.
  const auto thinned = Thin(Pulses(0.01), 3000);
  const auto& t = thinned.record.time_s;
  ASSERT_LE(t.size(), 3000U);
  const auto in = [&](double from_s, double to_s) {
    return std::count_if(t.begin(), t.end(), [&](double s) { return s > from_s && s <= to_s; });
  };
  EXPECT_GE(in(50.0, 51.0), 8);  // the first second of the first rest
  EXPECT_GE(in(51.0, 60.0), 8);  // a decade later
  EXPECT_GE(in(60.0, 150.0), 8);
}

TEST(Thin, KeepsTheChargeOfANoisyCurrent) {
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  Record record = Pulses(0.01);
  Measure(ThesisCell(), record);
  for (double& i : record.current_A) i += 2e-4 * normal(engine);  // 14 bits of 3 A
  const auto thinned = Thin(record, 3000);
  EXPECT_LT(thinned.record.size(), record.size() / 10);
  EXPECT_NEAR(DeliveredCharge(thinned.record).back(), DeliveredCharge(record).back(), 1e-9);
}

TEST(Thin, IsNotStoppedByNoiseBeyondItsTolerance) {
  // A shunt with 1 % noise: neighbouring rows are never equal, and the record must get short all
  // the same.
  std::mt19937 engine(3);
  std::normal_distribution<double> normal;
  for (const Hold hold : {Hold::kBackward, Hold::kForward}) {
    Record record = Pulses(0.05, hold);
    Measure(ThesisCell(), record);
    for (double& i : record.current_A) i += 0.03 * normal(engine);
    const auto thinned = Thin(record, 3000);
    EXPECT_LT(thinned.record.size(), 6000U);  // of 75 000
    EXPECT_NEAR(DeliveredCharge(thinned.record).back(), DeliveredCharge(record).back(), 1e-9);
    EXPECT_EQ(std::accumulate(thinned.row_weight.begin(), thinned.row_weight.end(), 0.0),
              static_cast<double>(record.size()));
  }
}

}  // namespace
}  // namespace lipoid
