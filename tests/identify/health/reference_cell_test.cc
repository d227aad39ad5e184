#include "identify/health/reference_cell.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

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

// Relative errors stay: four cells beside one another are no better known than one.
TEST(ReferenceCell, TheUncertaintyGrowsWithTheCell) {
  Cell cell = WithTypicalTemperature(NewFlightCell());
  cell.capacity_Ah = cell.alpha_C() / 3600.0;
  const auto& heat = *cell.temperature->heat;
  const std::vector<double> values{
      cell.alpha_C(), heat.heat_capacity_J_per_K, heat.thermal_resistance_K_per_W};
  cell.uncertainty = Cell::Uncertainty{.parameters = {"alpha", "C_th", "R_th"},
                                       .covariance = {},
                                       .degrees_of_freedom = 20.0,
                                       .soc_follows_alpha = false};
  for (std::size_t a = 0; a < values.size(); ++a) {
    cell.uncertainty->covariance.emplace_back(values.size(), 0.0);
    cell.uncertainty->covariance[a][a] = 0.01 * values[a] * values[a];
  }
  const Cell large = MakeReference(cell, 4, {}).cell;
  const auto& of_large = *large.temperature->heat;
  const std::vector<double> grown{
      large.alpha_C(), of_large.heat_capacity_J_per_K, of_large.thermal_resistance_K_per_W};
  for (std::size_t a = 0; a < values.size(); ++a) {
    EXPECT_NEAR(large.uncertainty->covariance[a][a],
                0.01 * grown[a] * grown[a],
                1e-12 * grown[a] * grown[a])
        << cell.uncertainty->parameters[a];
  }
}

// What nobody measured may be another: flights look for the charge beside it.
TEST(ReferenceCell, DoubtsAnEnergyOfDiffusionThatIsTaken) {
  const auto spread_of = [](const Cell& cell) {
    const auto& of = MakeReference(cell, 1, {}).cell.uncertainty;
    if (!of) return 0.0;
    const auto at = std::find(of->parameters.begin(), of->parameters.end(), "E_d");
    if (at == of->parameters.end()) return 0.0;
    const auto k = static_cast<std::size_t>(at - of->parameters.begin());
    return std::sqrt(of->covariance[k][k]);
  };
  EXPECT_EQ(spread_of(LoadCell("gifi-600mAh-1")), 20e3);
  Cell known = WithTypicalTemperature(NewFlightCell());
  EXPECT_EQ(spread_of(known), 0.0);
  // Beside what the reference says of its own error, which stays as it was.
  Cell lab = NewFlightCell();
  lab.uncertainty = {.parameters = {"alpha"}, .covariance = {{4.0}}, .degrees_of_freedom = 20.0};
  EXPECT_EQ(spread_of(lab), 20e3);
  const Cell::Uncertainty of = *MakeReference(lab, 1, {}).cell.uncertainty;
  EXPECT_EQ(of.covariance[0], (std::vector<double>{4.0, 0.0}));
  EXPECT_EQ(of.covariance[1][0], 0.0);
  EXPECT_EQ(of.degrees_of_freedom, 20.0);
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
