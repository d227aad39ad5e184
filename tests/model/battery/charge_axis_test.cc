#include "model/battery/charge_axis.h"

#include <gtest/gtest.h>

#include "model/battery/cell_file.h"

namespace lipoid {
namespace {

// What the cell is after a charge from the start, whatever the axis is called.
TEST(MoveChargeAxis, EveryCurveKeepsItsCharge) {
  constexpr double kStart = 0.9;
  constexpr double kRatio = 0.8;
  Cell cell = LoadCell("gifi-600mAh-1");
  cell.series_resistance_Ohm = Resistance<double>({0.1, 0.4, 0.95}, {0.09, 0.05, 0.04});
  cell.branches.assign(1, {Resistance<double>({0.0, 1.0}, {0.03, 0.01}), 20.0, std::nullopt});
  cell.charge_transfer = Cell::ChargeTransfer{0.5, Resistance<double>({0.2, 0.8}, {0.02, 0.01})};
  cell.hysteresis.emplace();
  cell.hysteresis->soc = {0.1, 0.9};
  cell.hysteresis->half_V = {0.01, 0.02};
  cell.hysteresis->folds = 40.0;
  const std::vector<OpenCircuitVoltage> curves = {
      OpenCircuitVoltage::Linear({0.0, 0.3, 1.0}, {3.2, 3.6, 4.2}),
      OpenCircuitVoltage::MonotoneCubic({0.0, 0.3, 0.6, 1.0}, {3.2, 3.6, 3.8, 4.2}),
      OpenCircuitVoltage::Polynomial(0.0, 1.0, {3.2, 0.7, 0.2, 0.1}),
      OpenCircuitVoltage::Fourier(0.0, 1.0, 2.5, {3.7, -0.3, 0.05}, {0.1, -0.02})};
  for (const OpenCircuitVoltage& curve : curves) {
    cell.open_circuit_voltage = curve;
    Cell moved = cell;
    MoveChargeAxis(moved, kStart, kRatio);
    for (const double soc : {0.05, 0.2, 0.35, 0.5, 0.77, 0.98}) {
      const double there = kStart - (kStart - soc) * kRatio;
      EXPECT_NEAR(moved.open_circuit_voltage(there), curve(soc), 1e-12) << soc;
      EXPECT_NEAR(moved.series_resistance_Ohm(there), cell.series_resistance_Ohm(soc), 1e-15);
      EXPECT_NEAR(
          moved.branches[0].resistance_Ohm(there), cell.branches[0].resistance_Ohm(soc), 1e-15);
      EXPECT_NEAR(moved.charge_transfer->resistance_Ohm(there),
                  cell.charge_transfer->resistance_Ohm(soc),
                  1e-15);
    }
    // A charge is a share of alpha, which is another: folds per charge stay.
    EXPECT_DOUBLE_EQ(moved.hysteresis->folds, 50.0);
    EXPECT_EQ(moved.alpha_C(), cell.alpha_C());
  }
}

}  // namespace
}  // namespace lipoid
