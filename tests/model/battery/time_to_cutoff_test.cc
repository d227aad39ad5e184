#include "model/battery/time_to_cutoff.h"

#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_file.h"
#include "model/battery/discharge_time.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;

// Empty at 3.0 V, full at 4.0 V, 1000 C: without diffusion the cut-off comes where the charge has
// lowered the voltage by what the drop leaves of the volt.
Cell StraightCell() {
  Cell cell;
  cell.capacity_Ah = 1000.0 / 3600.0;
  cell.cutoff_V = 3.0;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  cell.series_resistance_Ohm = 0.05;
  return cell;
}

TEST(TimeToCutoff, OfAnOhmicCellIsTheChargeThatItsDropLeaves) {
  const Cell cell = StraightCell();
  for (const double current_A : {0.1, 1.0, 5.0, 19.0}) {
    for (const double soc : {1.0, 0.96}) {
      const double expected = 1000.0 * (soc - 0.05 * current_A) / current_A;
      const auto found = TimeToCutoff(cell, current_A, soc, 2.0 * 1000.0 / current_A);
      if (expected <= 0.0) {
        EXPECT_EQ(found, 0.0) << current_A;
        continue;
      }
      // 30000 sums of charge: their roundings, in volts of 4 V.
      EXPECT_NEAR(*found, expected, 30000.0 * 4.0 * kEpsilon * 1000.0 / current_A) << current_A;
    }
  }
}

TEST(TimeToCutoff, KnowsThePack) {
  Cell pack = StraightCell();
  pack.series = 6;
  pack.parallel = 4;
  EXPECT_EQ(TimeToCutoff(pack, 8.0, 1.0, 1000.0), TimeToCutoff(StraightCell(), 2.0, 1.0, 1000.0));
}

TEST(TimeToCutoff, IsNoneWhereTheCellLastsLonger) {
  EXPECT_EQ(TimeToCutoff(StraightCell(), 1.0, 1.0, 949.0), std::nullopt);
  EXPECT_TRUE(TimeToCutoff(StraightCell(), 1.0, 1.0, 951.0).has_value());
  Cell flat = StraightCell();
  flat.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.5, 3.5});
  EXPECT_EQ(TimeToCutoff(flat, 1.0, 1.0, 1e6), std::nullopt);
}

// Where nothing drops and v_oc falls off a cliff at A = 0 it is the time of the diffusion alone.
TEST(TimeToCutoff, WithoutDropsIsTheTimeOfTheDiffusion) {
  Cell cell = StraightCell();
  cell.diffusion = Cell::Diffusion{.alpha_C = 1000.0, .beta_per_sqrt_s = 0.2, .terms = 400};
  cell.series_resistance_Ohm = 0.0;
  for (const double current_A : {0.5, 3.0, 9.0}) {
    const double expected = ExactDischargeTime(1000.0, 0.2, current_A);
    // The tail is quasi-static from mode 401 on, 1/(beta² 401²) = 0.16 ms.
    EXPECT_NEAR(*TimeToCutoff(cell, current_A, 1.0, 3.0 * expected), expected, 1e-6 * expected);
  }
}

// Put back: a cell with everything, run for that time, is at its cut-off.
TEST(TimeToCutoff, IsWhereTheWholeCellHasItsCutOff) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{Resistance<double>(0.03), 45.0, {}}};
  cell.self_heating = {.time_constant_s = 300.0, .resistance_drop_Ohm_per_A2 = 2e-3};
  cell.charge_transfer = {.current_A = 0.4, .resistance_Ohm = {{0.0, 0.5}, {0.09, 0.04}}};
  for (const double current_A : {0.6, 3.6}) {
    const auto time_s = TimeToCutoff(cell, current_A, 1.0, 3.0 * 1353.6 / current_A);
    ASSERT_TRUE(time_s.has_value());
    // Everything is exact under a constant current: one step gives what 30000 gave.
    const std::vector<double> stamps{0.0, *time_s};
    const std::vector<double> current{0.0, current_A};
    const double steepest_V = 15.0;
    EXPECT_NEAR(Predict(cell, stamps, current).voltage_V[1],
                cell.cutoff_V,
                30000.0 * 4.0 * kEpsilon * steepest_V)
        << current_A;
  }
}

// r_j(A) is held over a step: a table must be stepped through, and half as long steps move nothing.
TEST(TimeToCutoff, StepsThroughATableOfABranch) {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.branches = {{{{0.0, 0.2, 1.0}, {0.2, 0.05, 0.03}}, 45.0, {}}};
  const double coarse_s = *TimeToCutoff(cell, 3.0, 1.0, 3.0 * 400.0);
  const double fine_s = *TimeToCutoff(cell, 3.0, 1.0, 450.0);
  EXPECT_NE(coarse_s, fine_s);
  EXPECT_NEAR(coarse_s, fine_s, 1e-4 * fine_s);
  // And they are those of a record sampled ever so finely.
  std::vector<double> time_s;
  std::vector<double> current_A;
  for (int k = 0; k < 45000; ++k) {
    time_s.push_back(0.01 * k);
    current_A.push_back(3.0);
  }
  const auto voltage_V = Predict(cell, time_s, current_A).voltage_V;
  std::size_t row = 0;
  while (row < voltage_V.size() && voltage_V[row] > cell.cutoff_V) ++row;
  // One row, and what rows of 10 ms and steps of 15 ms hold r_j(A) too long.
  EXPECT_NEAR(fine_s, 0.01 * static_cast<double>(row), 0.015);
}

TEST(TimeToCutoff, IsFirstWhereTheVoltageComesBack) {
  // The thermal state gives back what the branch took: a dip at the beginning.
  Cell cell = StraightCell();
  cell.cutoff_V = 3.24;
  cell.series_resistance_Ohm = 0.2;
  cell.branches = {{Resistance<double>(0.1), 2.0, {}}};
  cell.self_heating = {.time_constant_s = 20.0, .resistance_drop_Ohm_per_A2 = 0.02};
  const double found_s = *TimeToCutoff(cell, 3.0, 1.0, 900.0);
  EXPECT_LT(found_s, 10.0);
  const std::vector<double> stamps{0.0, found_s, found_s + 30.0};
  const auto voltage_V = Predict(cell, stamps, std::vector<double>{0.0, 3.0, 3.0}).voltage_V;
  EXPECT_NEAR(voltage_V[1], 3.24, 1e-9);
  EXPECT_GT(voltage_V[2], 3.24);
}

TEST(TimeToCutoff, RefusesWhatIsNoDischarge) {
  EXPECT_THROW((void)TimeToCutoff(StraightCell(), 0.0, 1.0, 100.0), PreconditionError);
  EXPECT_THROW((void)TimeToCutoff(StraightCell(), -1.0, 1.0, 100.0), PreconditionError);
  EXPECT_THROW((void)TimeToCutoff(StraightCell(), 1.0, 1.0, 0.0), PreconditionError);
  EXPECT_THROW((void)TimeToCutoff(StraightCell(), 1.0, 1.0, INFINITY), PreconditionError);
}

}  // namespace
}  // namespace lipoid
