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
  Record most = Pulses(1.0);
  Record few = Pulses(1.0, Hold::kBackward, 3);
  Measure(ThesisCell(), most);
  Measure(RcCell(0.5, 0.03, 45.0), few);
  for (const auto& both : {FindStartValues({&most, &few}), FindStartValues({&few, &most})}) {
    EXPECT_GT(both.series_resistance_Ohm, 0.13);  // diffusion in a second comes on top
    EXPECT_LT(both.series_resistance_Ohm, 0.20);
  }
}

TEST(StartValues, AreNotNumbersWhereNothingShowsThem) {
  Record rest = test::RecordOfSteps({{600.0, 0.0, 10.0}});
  for (const auto& start : {FindStartValues({&rest}), FindStartValues({})}) {
    EXPECT_TRUE(std::isnan(start.series_resistance_Ohm));
    EXPECT_TRUE(std::isnan(start.relaxation_s));
    EXPECT_TRUE(std::isnan(start.relaxation_Ohm));
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

}  // namespace
}  // namespace lipoid
