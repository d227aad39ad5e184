#include "identify/health/reference_cell.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"
#include "model/battery/prediction.h"
#include "tests/support/synthetic_flight.h"

namespace lipoid::test {
namespace {

// Twice the capacity at twice the current is the same voltage.
TEST(ReferenceCell, LargerIsTheSameAtTheSameRate) {
  Cell small = WithTypicalTemperature(NewFlightCell());
  small.temperature->heat.reset();  // the surface grows with less than the volume
  const ReferenceCell large = MakeReference(small, 1, 10.0);
  const std::vector<double> time_s{0.0, 10.0, 20.0, 60.0, 100.0};
  const std::vector<double> current_A{0.0, 20.0, 20.0, 0.0, 30.0};
  std::vector<double> twice_A;
  for (const double i : current_A) twice_A.push_back(2.0 * i);
  const auto of_small = Predict(small, time_s, current_A);
  const auto of_large = Predict(large.cell, time_s, twice_A);
  for (std::size_t k = 0; k < time_s.size(); ++k)
    EXPECT_NEAR(of_large.voltage_V[k], of_small.voltage_V[k], 1e-12);
  EXPECT_NEAR(large.cell.alpha_C(), 36000.0, 1e-9);
}

TEST(ReferenceCell, OfParallelCellsIsTheirSum) {
  EXPECT_NEAR(MakeReference(NewFlightCell(), 3, {}).cell.alpha_C(), 3.0 * 18000.0, 1e-9);
}

TEST(ReferenceCell, AssumedCurvesAreMarkedAndSpreadWider) {
  const ReferenceCell lab = MakeReference(NewFlightCell(), 1, {});
  const ReferenceCell shipped = MakeReference(LoadCell("gifi-600mAh-1"), 1, {});
  EXPECT_FALSE(lab.typical);
  EXPECT_TRUE(shipped.typical);
  EXPECT_GT(shipped.spread.curve_V, lab.spread.curve_V);
  EXPECT_GT(shipped.spread.log_series, lab.spread.log_series);
  // The shipped cell's branch is next to none: one is put in its place.
  EXPECT_GT(shipped.cell.branches.at(0).resistance_Ohm(0.5), 0.01);
}

}  // namespace
}  // namespace lipoid::test
