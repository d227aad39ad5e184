#include "model/battery/prediction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "model/core/errors.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;

// Counts charge and drops r_s i, in powers of two.
Cell PlainCell() {
  Cell cell;
  cell.capacity_Ah = 1024.0 / 3600.0;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  cell.series_resistance_Ohm = 0.125;
  return cell;
}

TEST(Prediction, GivesVoltageOpenCircuitVoltageAndStateOfCharge) {
  const std::vector<double> time_s = {0.0, 64.0, 128.0, 192.0};
  const std::vector<double> current_A = {0.0, 2.0, 2.0, 0.0};
  const auto prediction = Predict(PlainCell(), time_s, current_A);
  const double soc[] = {1.0, 0.875, 0.75, 0.75};
  const double drop_V[] = {0.0, 0.25, 0.25, 0.0};
  for (int k = 0; k < 4; ++k) {
    // The capacity in Ah is rounded.
    EXPECT_NEAR(prediction.soc[k], soc[k], 4.0 * kEpsilon) << k;
    EXPECT_NEAR(prediction.open_circuit_V[k], 3.0 + soc[k], 16.0 * kEpsilon) << k;
    EXPECT_NEAR(prediction.voltage_V[k], 3.0 + soc[k] - drop_V[k], 16.0 * kEpsilon) << k;
  }
}

TEST(Prediction, PackIsItsCellsTogether) {
  Cell one = PlainCell();
  one.diffusion = Cell::Diffusion{.alpha_C = 1100.0, .beta_per_sqrt_s = 0.2};
  one.branches.push_back({.resistance_Ohm = 0.03, .time_constant_s = 20.0, .capacitance_F = {}});
  Cell pack = one;
  pack.series = 6;
  pack.parallel = 4;
  std::mt19937 engine(12);
  std::uniform_real_distribution<double> current(-1.0, 2.0);
  std::vector<double> time_s;
  std::vector<double> cell_A;
  std::vector<double> pack_A;
  for (int k = 0; k < 200; ++k) {
    time_s.push_back(1.5 * k);
    cell_A.push_back(current(engine));
    pack_A.push_back(4.0 * cell_A.back());
  }
  const auto of_cell = Predict(one, time_s, cell_A);
  const auto of_pack = Predict(pack, time_s, pack_A);
  for (int k = 0; k < 200; ++k) {
    EXPECT_EQ(of_pack.voltage_V[k], 6.0 * of_cell.voltage_V[k]) << k;
    EXPECT_EQ(of_pack.open_circuit_V[k], 6.0 * of_cell.open_circuit_V[k]) << k;
    EXPECT_EQ(of_pack.soc[k], of_cell.soc[k]) << k;
  }
  EXPECT_LT(of_cell.soc.back(), 0.95);
}

TEST(Prediction, CountsRowsBeyondTheCurveAndStillPredictsThem) {
  const std::vector<double> time_s = {0.0, 512.0, 1024.0, 1280.0, 1536.0};
  const std::vector<double> current_A = {0.0, 1.0, 1.0, 1.0, 1.0};
  const auto prediction = Predict(PlainCell(), time_s, current_A, Hold::kBackward, 0.75);
  EXPECT_NEAR(prediction.soc[1], 0.25, 4.0 * kEpsilon);
  EXPECT_NEAR(prediction.soc[2], -0.25, 4.0 * kEpsilon);
  EXPECT_EQ(prediction.rows_outside_curve, 3U);
  EXPECT_NEAR(
      prediction.voltage_V[4], 3.0 - 0.75 - 0.125, 16.0 * kEpsilon);  // end slope, 1 V per unit
}

TEST(Prediction, InitialStateOfChargeShiftsTheWholeRecord) {
  const std::vector<double> time_s = {0.0, 10.0, 20.0};
  const std::vector<double> current_A = {1.0, 1.0, 1.0};
  const auto full = Predict(PlainCell(), time_s, current_A, Hold::kForward, 1.0);
  const auto half = Predict(PlainCell(), time_s, current_A, Hold::kForward, 0.5);
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(full.soc[k] - half.soc[k], 0.5, 4.0 * kEpsilon) << k;
  EXPECT_LT(full.soc[2], full.soc[1]);
}

TEST(Prediction, OfAnEmptyRecordIsEmpty) {
  const auto prediction = Predict(PlainCell(), {}, {});
  EXPECT_TRUE(prediction.voltage_V.empty());
  EXPECT_EQ(prediction.rows_outside_curve, 0U);
}

TEST(Prediction, RefusesColumnsOfDifferentLengthAndTimeThatRunsBackwards) {
  const std::vector<double> one = {0.0};
  const std::vector<double> two = {0.0, 1.0};
  const std::vector<double> back = {1.0, 0.0};
  EXPECT_THROW((void)Predict(PlainCell(), two, one), PreconditionError);
  EXPECT_THROW((void)Predict(PlainCell(), back, two), PreconditionError);
}

}  // namespace
}  // namespace lipoid
