#include "model/battery/charge_transfer.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>

#include "model/battery/cell_model.h"
#include "model/battery/record_stepper.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;
constexpr double kScale_A = 0.5;
constexpr double kResistance_Ohm = 0.06;

const ChargeTransfer<double> kTerm{kScale_A, kResistance_Ohm};

// asinh x = x - x³/6 + 3 x^5/40 - ...: below a tenth of i_0 the series ends within 4e-8 of itself.
TEST(ChargeTransfer, IsAResistanceForSmallCurrents) {
  for (const double x : {1e-9, 1e-4, 0.01, 0.1}) {
    const double expected = kResistance_Ohm * kScale_A * x * (1.0 - x * x / 6.0);
    const double next = kResistance_Ohm * kScale_A * 3.0 / 40.0 * std::pow(x, 5);
    EXPECT_NEAR(kTerm.Drop(0.5, x * kScale_A), expected, next + 4.0 * kEpsilon * expected) << x;
    EXPECT_EQ(kTerm.Drop(0.5, -x * kScale_A), -kTerm.Drop(0.5, x * kScale_A));
  }
  EXPECT_EQ(kTerm.Drop(0.5, 0.0), 0.0);
  EXPECT_EQ(SlopeOfDrop(kTerm, 0.5, 0.0), kResistance_Ohm);
}

// asinh x = ln 2x + 1/(4 x²) - ...: Tafel's law.
TEST(ChargeTransfer, GrowsWithTheLogarithmOfLargeCurrents) {
  for (const double x : {100.0, 1e4, 1e9}) {
    const double expected = kResistance_Ohm * kScale_A * std::log(2.0 * x);
    const double next = kResistance_Ohm * kScale_A / (4.0 * x * x);
    EXPECT_NEAR(kTerm.Drop(0.5, x * kScale_A), expected, next + 4.0 * kEpsilon * expected) << x;
  }
}

TEST(ChargeTransfer, SlopeIsThatOfTheDrop) {
  for (const double current_A : {-5.0, -0.3, 0.0, 0.7, 20.0}) {
    const auto f = [](double i) { return kTerm.Drop(0.5, i); };
    const auto difference = test::Ridders(f, current_A, 0.1);
    EXPECT_NEAR(SlopeOfDrop(kTerm, 0.5, current_A), difference.value, 1e-11) << current_A;
  }
}

TEST(ChargeTransfer, AddsItsDropToTheCellsAtItsStateOfCharge) {
  CellParameters<double> cell;
  cell.alpha_C = 1000.0;
  cell.diffusion = false;
  cell.series_resistance_Ohm = 0.1;
  cell.branches = {{0.03, 45.0}};
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  const CellModel<double> without(cell);
  cell.charge_transfer = {kScale_A, Resistance<double>({0.0, 1.0}, {0.2, 0.04})};
  const CellModel<double> with(cell);
  auto state = with.Relaxed(0.75);
  with.Advance(state, 2.0, with.MakeStep(100.0));  // to A = 0.55
  const double expected = (0.2 - 0.55 * 0.16) * kScale_A * std::asinh(2.0 / kScale_A);
  EXPECT_NEAR(without.Voltage(state, 2.0) - with.Voltage(state, 2.0), expected, 32.0 * kEpsilon);
  EXPECT_EQ(with.Voltage(state, 0.0), without.Voltage(state, 0.0)) << "it has no inertia";
  EXPECT_TRUE(std::isnan(with.Voltage(state, std::nan(""))));
}

TEST(ChargeTransfer, WithoutResistanceIsAsIfItWereNotThere) {
  CellParameters<double> cell;
  cell.alpha_C = 1353.6;
  cell.beta_per_sqrt_s = 0.1924;
  cell.series_resistance_Ohm = 0.13;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.25});
  const CellModel<double> without(cell);
  cell.charge_transfer = {kScale_A, 0.0};
  const CellModel<double> with(cell);
  auto state = with.Relaxed(0.9);
  for (const double current_A : {0.0, 1e-3, 3.0, -7.0}) {
    EXPECT_EQ(with.Voltage(state, current_A), without.Voltage(state, current_A));
  }
}

constexpr int kTransferUnknowns = 5;
const char* const kTransferNames[kTransferUnknowns] = {
    "i_0", "r_ct at 0", "r_ct at 1", "r_s", "current"};

template <class T>
T LastVoltageOfTransfer(const std::vector<T>& x) {
  CellParameters<T> cell;
  cell.alpha_C = T(1353.6);
  cell.diffusion = false;
  cell.charge_transfer = ChargeTransfer<T>{x[0], Resistance<T>({0.0, 1.0}, {x[1], x[2]})};
  cell.series_resistance_Ohm = x[3];
  cell.open_circuit_voltage = OpenCircuitVoltage::Polynomial(-1.0, 2.0, {3.6, 0.5, -0.06});
  const CellModel<T> model(cell);
  RecordStepper<T> stepper(model, Hold::kBackward, model.Relaxed(T(1.0)));
  for (int k = 0; k < 40; ++k) stepper.Row(7.0 * k, (k % 3 == 0 ? 1.0 : -0.3) * x[4]);
  return stepper.Voltage();
}

TEST(ChargeTransfer, DerivativesAreThoseOfRiddersDifferences) {
  using Jet = ceres::Jet<double, kTransferUnknowns>;
  for (const double scale_A : {0.05, 0.5, 50.0}) {
    const std::vector<double> at = {scale_A, 0.05, 0.02, 0.13, 1.5};
    std::vector<Jet> jets;
    for (int k = 0; k < kTransferUnknowns; ++k) jets.emplace_back(at[k], k);
    const Jet voltage = LastVoltageOfTransfer(jets);
    EXPECT_NEAR(voltage.a, LastVoltageOfTransfer(at), 16.0 * kEpsilon * voltage.a);
    for (int k = 0; k < kTransferUnknowns; ++k) {
      const auto f = [&](double x) {
        auto moved = at;
        moved[k] = x;
        return LastVoltageOfTransfer(moved);
      };
      const auto difference = test::Ridders(f, at[k], 0.1 * at[k]);
      // As in cell_model_test.cc: rounding of a 4 V value over a step of 1 % of the parameter.
      const double tolerance = 1e-8 * std::abs(difference.value) + 1e3 * kEpsilon / at[k];
      EXPECT_NEAR(voltage.v[k], difference.value, tolerance)
          << kTransferNames[k] << " i_0 " << scale_A;
      EXPECT_NE(voltage.v[k], 0.0) << kTransferNames[k];
    }
  }
}

}  // namespace
}  // namespace lipoid
