#include "model/battery/hysteresis.h"

#include <ceres/jet.h>
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "model/battery/cell_model.h"
#include "model/battery/record_stepper.h"
#include "tests/support/constants.h"
#include "tests/support/ridders.h"

namespace lipoid {
namespace {

using test::kEpsilon;
constexpr double kAlpha_C = 10000.0;
constexpr double kFolds = 30.0;
constexpr double kHalf_V = 0.02;

CellParameters<double> CellWithMemory() {
  CellParameters<double> cell;
  cell.alpha_C = kAlpha_C;
  cell.diffusion = false;
  cell.series_resistance_Ohm = 0.05;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.2});
  cell.hysteresis = Hysteresis<double>{kFolds, {}, {kHalf_V}};
  return cell;
}

TEST(Hysteresis, FollowsTheDirectionOfTheCharge) {
  const CellModel<double> model(CellWithMemory());
  auto state = model.Relaxed(1.0);
  EXPECT_EQ(state.hysteresis, 1.0) << "a full cell was charged";
  EXPECT_EQ(model.Relaxed(0.5).hysteresis, -1.0) << "another was discharged";
  // (h + 1) = 2 e^{-gamma q/alpha}, whatever the current: two currents, and rests between.
  double charge_C = 0.0;
  for (const auto& [current_A, dt_s] : {std::pair{2.0, 100.0}, {0.0, 900.0}, {7.0, 30.0}}) {
    model.Advance(state, current_A, model.MakeStep(dt_s));
    charge_C += current_A * dt_s;
    EXPECT_NEAR(
        state.hysteresis, 2.0 * std::exp(-kFolds * charge_C / kAlpha_C) - 1.0, 8 * kEpsilon);
  }
  const double before = state.hysteresis;
  model.Advance(state, -4.0, model.MakeStep(50.0));
  EXPECT_NEAR(
      state.hysteresis, 1.0 + (before - 1.0) * std::exp(-kFolds * 200.0 / kAlpha_C), 8 * kEpsilon);
}

TEST(Hysteresis, AddsItsVoltageToTheCurve) {
  auto cell = CellWithMemory();
  cell.hysteresis->soc = {0.0, 1.0};
  cell.hysteresis->half_V = {0.04, 0.01};
  const CellModel<double> model(cell);
  auto state = model.Relaxed(0.5);
  for (const double h : {-1.0, 0.0, 0.4, 1.0}) {
    state.hysteresis = h;
    EXPECT_NEAR(model.Voltage(state, 0.0), 3.6 + 0.025 * h, 4.0 * kEpsilon * 3.6);
    EXPECT_NEAR(model.Voltage(state, 2.0), 3.6 + 0.025 * h - 0.1, 4.0 * kEpsilon * 3.6);
  }
}

// The area of a closed loop over the charge Q at both ends of which h turns is the integral of
// 2 M h: with m = gamma Q/alpha, h goes from h_0 = tanh(m/2) to -h_0 and back, and each half holds
//   M alpha/gamma (2 h_0 - m), of one sign, so that the loop holds 2 M (Q - 2 h_0 alpha/gamma).
TEST(Hysteresis, AreaOfTheLoopIsThatOfItsIntegral) {
  const CellModel<double> model(CellWithMemory());
  auto state = model.Relaxed(0.9);
  const double charge_C = 0.6 * kAlpha_C;
  constexpr int kSteps = 20'000;
  const auto step = model.MakeStep(1.0);
  const double current_A = charge_C / kSteps;
  const auto half_loop = [&](double sign) {
    double area_J = 0.0;
    for (int k = 0; k < kSteps; ++k) {
      const double before_V = model.OpenCircuit(state, 0.0);
      model.Advance(state, sign * current_A, step);
      area_J += 0.5 * (before_V + model.OpenCircuit(state, 0.0)) * sign * current_A;
    }
    return area_J;
  };
  for (int k = 0; k < 4; ++k) {  // until the loop is closed
    half_loop(1.0);
    half_loop(-1.0);
  }
  const double area_J = -(half_loop(1.0) + half_loop(-1.0));
  const double m = kFolds * 0.6;
  const double expected_J =
      2.0 * kHalf_V * (charge_C - 2.0 * std::tanh(0.5 * m) * kAlpha_C / kFolds);
  EXPECT_GT(expected_J, 100.0);
  EXPECT_NEAR(area_J, expected_J, 1e-5 * expected_J);  // trapezoids of m/20000 folds
}

TEST(Hysteresis, WithoutVoltageIsAsIfItWereNotThere) {
  auto cell = CellWithMemory();
  cell.hysteresis->half_V = {0.0};
  const CellModel<double> with(cell);
  cell.hysteresis.reset();
  const CellModel<double> without(cell);
  RecordStepper<double> a(with, Hold::kBackward, with.Relaxed(1.0));
  RecordStepper<double> b(without, Hold::kBackward, without.Relaxed(1.0));
  for (int k = 0; k < 200; ++k) {
    a.Row(1.3 * k, std::sin(0.2 * k));
    b.Row(1.3 * k, std::sin(0.2 * k));
    ASSERT_EQ(a.Voltage(), b.Voltage()) << k;
  }
}

constexpr int kHysteresisUnknowns = 4;
const char* const kHysteresisNames[kHysteresisUnknowns] = {"gamma", "M at 0", "M at 1", "current"};

template <class T>
T LastVoltageOfHysteresis(const std::vector<T>& x) {
  CellParameters<T> cell;
  cell.alpha_C = T(kAlpha_C);
  cell.diffusion = false;
  cell.open_circuit_voltage = OpenCircuitVoltage::Polynomial(-1.0, 2.0, {3.6, 0.5, -0.06});
  cell.hysteresis = Hysteresis<T>{x[0], {0.0, 1.0}, {x[1], x[2]}};
  const CellModel<T> model(cell);
  RecordStepper<T> stepper(model, Hold::kBackward, model.Relaxed(T(1.0)));
  for (int k = 0; k < 40; ++k) stepper.Row(7.0 * k, (k % 3 == 0 ? 1.0 : -0.3) * x[3]);
  return stepper.Voltage();
}

TEST(Hysteresis, DerivativesAreThoseOfRiddersDifferences) {
  using Jet = ceres::Jet<double, kHysteresisUnknowns>;
  const std::vector<double> at = {kFolds, 0.03, 0.02, 3.0};
  std::vector<Jet> jets;
  for (int k = 0; k < kHysteresisUnknowns; ++k) jets.emplace_back(at[k], k);
  const Jet voltage = LastVoltageOfHysteresis(jets);
  EXPECT_NEAR(voltage.a, LastVoltageOfHysteresis(at), 16.0 * kEpsilon * voltage.a);
  for (int k = 0; k < kHysteresisUnknowns; ++k) {
    const auto f = [&](double x) {
      auto moved = at;
      moved[k] = x;
      return LastVoltageOfHysteresis(moved);
    };
    const auto difference = test::Ridders(f, at[k], 0.1 * at[k]);
    const double tolerance = 1e-8 * std::abs(difference.value) + 1e3 * kEpsilon / at[k];
    EXPECT_NEAR(voltage.v[k], difference.value, tolerance) << kHysteresisNames[k];
    EXPECT_NE(voltage.v[k], 0.0) << kHysteresisNames[k];
  }
}

}  // namespace
}  // namespace lipoid
