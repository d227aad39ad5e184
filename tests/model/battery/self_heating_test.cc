#include "model/battery/self_heating.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/battery/cell_model.h"
#include "model/battery/record_stepper.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;
constexpr double kTau_s = 300.0;
constexpr double kRho = 2e-3;
constexpr double kSeries_Ohm = 0.13;

// Nothing but v_oc and a series resistance, so that the drop is what remains.
CellParameters<double> WarmingCell() {
  CellParameters<double> cell;
  cell.alpha_C = 1353.6;
  cell.diffusion = false;
  cell.series_resistance_Ohm = kSeries_Ohm;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.25});
  cell.self_heating = SelfHeating<double>{kTau_s, kRho};
  return cell;
}

double Drop(const CellModel<double>& model,
            const CellModel<double>::State& state,
            double current_A) {
  return model.OpenCircuit(state, current_A) - model.Voltage(state, current_A);
}

TEST(SelfHeating, WarmthUnderConstantCurrentApproachesItsSquare) {
  const CellModel<double> model(WarmingCell());
  std::mt19937 engine(5);
  std::uniform_real_distribution<double> logarithm(std::log(0.003), std::log(60.0));
  for (const double current_A : {3.0, -1.2}) {  // charging warms as well
    auto state = model.Relaxed(0.9);
    EXPECT_EQ(state.thermal_state_A2, 0.0);
    double time_s = 0.0;
    for (int k = 0; k < 200; ++k) {
      const double dt_s = std::exp(logarithm(engine));
      model.Advance(state, current_A, model.MakeStep(dt_s));
      time_s += dt_s;
      const double expected = current_A * current_A * -std::expm1(-time_s / kTau_s);
      // Four roundings of each step.
      ASSERT_NEAR(state.thermal_state_A2, expected, 200 * 4.0 * kEpsilon * expected) << time_s;
      // Two roundings of the voltage, 4 V.
      ASSERT_NEAR(Drop(model, state, current_A),
                  (kSeries_Ohm - kRho * expected) * current_A,
                  16.0 * kEpsilon)
          << time_s;
    }
  }
}

TEST(SelfHeating, WarmthIsLostInARestWithItsTimeConstant) {
  const CellModel<double> model(WarmingCell());
  auto state = model.Relaxed(0.9);
  model.Advance(state, 2.0, model.MakeStep(1e9));
  EXPECT_NEAR(state.thermal_state_A2, 4.0, 8.0 * kEpsilon);
  model.Advance(state, 0.0, model.MakeStep(kTau_s));
  EXPECT_NEAR(state.thermal_state_A2, 4.0 * std::exp(-1.0), 8.0 * kEpsilon);
}

TEST(SelfHeating, NeverTakesMoreThanAResistanceCanLose) {
  const CellModel<double> model(WarmingCell());
  auto state = model.Relaxed(0.9);
  // 3/4 of r_s is gone where rho h = 0.75 r_s, at 6.98 A in the long run.
  const double edge_A = std::sqrt(0.75 * kSeries_Ohm / kRho);
  for (const double current_A : {0.5, 0.999, 1.001, 3.0, 1e3}) {
    state.thermal_state_A2 = current_A * current_A * edge_A * edge_A;
    const double straight_Ohm = kSeries_Ohm - kRho * state.thermal_state_A2;
    const double expected = current_A < 1.0 ? straight_Ohm : kLeastSeriesShare * kSeries_Ohm;
    EXPECT_NEAR(Drop(model, state, 1.0), expected, 16.0 * kEpsilon) << current_A;
  }
}

TEST(SelfHeating, LowersTheTableAtTheChargeItIsAt) {
  auto cell = WarmingCell();
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.4, 0.1});
  const CellModel<double> model(cell);
  auto state = model.Relaxed(0.5);
  state.thermal_state_A2 = 10.0;
  EXPECT_NEAR(model.SeriesResistance(state, 0.5), 0.25 - kRho * 10.0, 2.0 * kEpsilon);
}

TEST(SelfHeating, ANaNStaysOne) {
  const CellModel<double> model(WarmingCell());
  auto state = model.Relaxed(0.5);
  model.Advance(state, std::nan(""), model.MakeStep(1.0));
  EXPECT_TRUE(std::isnan(model.SeriesResistance(state, 0.5)));
}

// A term that does nothing changes no bit, whatever else the cell has.
TEST(SelfHeating, WithoutAnyDropIsAsIfItWereNotThere) {
  auto cell = WarmingCell();
  cell.diffusion = true;
  cell.beta_per_sqrt_s = 0.1924;
  cell.branches = {{0.03, 45.0}, {Resistance<double>({0.0, 1.0}, {0.1, 0.2}), 3.0}};
  cell.self_heating->resistance_drop_Ohm_per_A2 = 0.0;
  const CellModel<double> with(cell);
  cell.self_heating.reset();
  const CellModel<double> without(cell);
  RecordStepper<double> a(with, Hold::kBackward, with.Relaxed(1.0));
  RecordStepper<double> b(without, Hold::kBackward, without.Relaxed(1.0));
  for (int k = 0; k < 500; ++k) {
    const double current_A = 3.0 * std::sin(0.1 * k);
    a.Row(0.37 * k, current_A);
    b.Row(0.37 * k, current_A);
    ASSERT_EQ(a.Voltage(), b.Voltage()) << k;
  }
}

constexpr int kHeatingUnknowns = 4;
const char* const kHeatingNames[kHeatingUnknowns] = {"r_s", "tau_h", "rho_h", "current"};

template <class T>
T LastVoltageOfSelfHeating(const std::vector<T>& x) {
  CellParameters<T> cell;
  cell.alpha_C = T(1353.6);
  cell.diffusion = false;
  cell.series_resistance_Ohm = x[0];
  cell.self_heating = SelfHeating<T>{x[1], x[2]};
  cell.open_circuit_voltage = OpenCircuitVoltage::Polynomial(-1.0, 2.0, {3.6, 0.5, -0.06});
  const CellModel<T> model(cell);
  RecordStepper<T> stepper(model, Hold::kBackward, model.Relaxed(T(1.0)));
  for (int k = 0; k < 40; ++k) stepper.Row(7.0 * k, (k % 3 == 0 ? 1.0 : -0.3) * x[3]);
  return stepper.Voltage();
}

TEST(SelfHeating, DerivativesAreThoseOfRiddersDifferences) {
  using Jet = ceres::Jet<double, kHeatingUnknowns>;
  // Below the least share, and far beyond it: there only r_s and the current matter.
  for (const double current_A : {3.0, 60.0}) {
    const std::vector<double> at = {kSeries_Ohm, kTau_s, kRho, current_A};
    std::vector<Jet> jets;
    for (int k = 0; k < kHeatingUnknowns; ++k) jets.emplace_back(at[k], k);
    const Jet voltage = LastVoltageOfSelfHeating(jets);
    EXPECT_NEAR(voltage.a, LastVoltageOfSelfHeating(at), 16.0 * kEpsilon * voltage.a);
    for (int k = 0; k < kHeatingUnknowns; ++k) {
      const auto f = [&](double x) {
        auto moved = at;
        moved[k] = x;
        return LastVoltageOfSelfHeating(moved);
      };
      const auto difference = test::Ridders(f, at[k], 0.1 * at[k]);
      // As in cell_model_test.cc: rounding of a 4 V value over a step of 1 % of the parameter.
      const double tolerance = 1e-8 * std::abs(difference.value) + 1e3 * kEpsilon / at[k];
      EXPECT_NEAR(voltage.v[k], difference.value, tolerance)
          << kHeatingNames[k] << " " << current_A;
      if (current_A < 10.0 || kHeatingNames[k] == kHeatingNames[0] ||
          kHeatingNames[k] == kHeatingNames[3]) {
        EXPECT_NE(voltage.v[k], 0.0) << kHeatingNames[k];
      } else {
        EXPECT_EQ(voltage.v[k], 0.0) << kHeatingNames[k];
      }
    }
  }
}

}  // namespace
}  // namespace lipoid
