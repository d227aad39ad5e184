#include "model/battery/aged_cell.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

Cell WithBranch() {
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.diffusion.reset();
  cell.capacity_Ah = 0.5;
  cell.branches = {{.resistance_Ohm = 0.05, .time_constant_s = 30.0, .capacitance_F = 600.0}};
  cell.charge_transfer = {.current_A = 1.0, .resistance_Ohm = {{0.0, 1.0}, {0.09, 0.04}}};
  return cell;
}

// Twice the resistance is twice every drop, at all times; half the capacity is half the charge at
// the same state of charge.
TEST(AgedCell, DropsGrowAndChargeShrinks) {
  const Cell young = WithBranch();
  const Cell old = Aged(young, 0.5, 2.0);
  EXPECT_EQ(old.alpha_C(), 0.5 * young.alpha_C());
  const CellModel<double> young_model(young.Parameters());
  const CellModel<double> old_model(old.Parameters());
  auto a = young_model.Relaxed(0.9);
  auto b = old_model.Relaxed(0.9);
  for (const double dt_s : {1.0, 20.0, 100.0}) {
    // The same states of charge need half the charge; the currents are alike where the drops are
    // compared.
    young_model.Advance(a, 1.5, young_model.MakeStep(dt_s));
    old_model.Advance(b, 1.5, old_model.MakeStep(dt_s));
    const double young_drop_V = young_model.OpenCircuit(a, 1.5) - young_model.Voltage(a, 1.5);
    b.delivered_C = 0.5 * a.delivered_C;
    EXPECT_NEAR(old_model.Soc(b, 1.5), young_model.Soc(a, 1.5), 1e-12);
    const double old_drop_V = old_model.OpenCircuit(b, 1.5) - old_model.Voltage(b, 1.5);
    EXPECT_NEAR(old_drop_V, 2.0 * young_drop_V, 1e-12) << dt_s;
  }
  EXPECT_EQ(*old.branches[0].capacitance_F, 300.0);
}

TEST(AgedCell, DiffusionHoldsBackAsMuch) {
  const Cell young = LoadCell("gifi-600mAh-1");
  const Cell old = Aged(young, 0.8, 1.0);
  EXPECT_EQ(old.diffusion->alpha_C, 0.8 * young.diffusion->alpha_C);
  EXPECT_EQ(old.diffusion->beta_per_sqrt_s, young.diffusion->beta_per_sqrt_s);
  EXPECT_EQ(old.series_resistance_Ohm.resistance_Ohm, young.series_resistance_Ohm.resistance_Ohm);
}

// Five times the current is the same voltage and temperature, with everything that a cell may have.
TEST(AgedCell, AResizedCellIsTheSameAtAsManyTimesTheCurrent) {
  Cell small = LoadCell("gifi-600mAh-1");
  small.branches = {{.resistance_Ohm = 0.05, .time_constant_s = 30.0, .capacitance_F = 600.0}};
  small.charge_transfer = {.current_A = 1.0, .resistance_Ohm = {{0.0, 1.0}, {0.09, 0.04}}};
  Cell heating = small;
  heating.self_heating =
      Cell::SelfHeating{.time_constant_s = 60.0, .resistance_drop_Ohm_per_A2 = 0.002};
  for (const Cell& cell : {WithTypicalTemperature(small), heating}) {
    const Cell large = Resized(cell, 5.0);
    EXPECT_EQ(large.capacity_Ah, 5.0 * cell.capacity_Ah);
    const CellModel<double> small_model(cell.Parameters());
    const CellModel<double> large_model(large.Parameters());
    auto a = small_model.Relaxed(0.9);
    auto b = large_model.Relaxed(0.9);
    a.ambient_K = b.ambient_K = a.temperature_K;
    for (const double dt_s : {1.0, 20.0, 100.0}) {
      small_model.Advance(a, 1.5, small_model.MakeStep(dt_s));
      large_model.Advance(b, 7.5, large_model.MakeStep(dt_s));
      EXPECT_NEAR(large_model.Voltage(b, 7.5), small_model.Voltage(a, 1.5), 1e-12) << dt_s;
      EXPECT_NEAR(b.temperature_K, a.temperature_K, 1e-9) << dt_s;
    }
  }
}

TEST(AgedCell, ItsUncertaintyIsThatOfTheYoungCell) {
  Cell young = WithBranch();
  young.uncertainty =
      Cell::Uncertainty{.parameters = {"r_s"}, .covariance = {{1e-4}}, .degrees_of_freedom = 10.0};
  EXPECT_FALSE(Aged(young, 1.0, 1.0).uncertainty);
}

TEST(AgedCell, NothingIsLeftOfNothing) {
  EXPECT_THROW((void)Aged(WithBranch(), 0.0, 1.0), PreconditionError);
  EXPECT_THROW((void)Aged(WithBranch(), 1.0, -1.0), PreconditionError);
}

}  // namespace
}  // namespace lipoid
