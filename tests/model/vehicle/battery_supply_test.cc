#include "model/vehicle/battery_supply.h"

#include <gtest/gtest.h>

#include <boost/math/tools/toms748_solve.hpp>
#include <cmath>
#include <numbers>

#include "model/battery/prediction.h"
#include "model/vehicle/vehicle_file.h"
#include "tests/support/constants.h"

namespace lipoid {
namespace {

using test::kEpsilon;
using test::kFlightStep_s;
// Sums of a dozen terms of up to 4.2 V.
constexpr double kRounding_V = 64.0 * kEpsilon;

// A cell whose curve is one straight line, so that a supply is exact at any current.
Cell StraightCell() {
  Cell cell;
  cell.name = "straight";
  cell.capacity_Ah = 0.6;
  cell.cutoff_V = 3.0;
  cell.diffusion = Cell::Diffusion{.alpha_C = 1353.6, .beta_per_sqrt_s = 0.1924};
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.2, 4.2});
  cell.series_resistance_Ohm = {0.13};
  cell.branches = {{.resistance_Ohm = {0.03}, .time_constant_s = 20.0, .capacitance_F = {}},
                   {.resistance_Ohm = {0.01}, .time_constant_s = 0.5, .capacitance_F = {}}};
  return cell;
}

// The current of step k: climbs, rests and charges for a moment.
double Current_A(int step) {
  return 2.0 + 1.5 * std::sin(0.01 * step) - (step % 7 == 0 ? 4.0 : 0.0);
}

double At(const Supply<double>& supply, double current_A) {
  return supply.voltage_V - supply.resistance_Ohm * current_A;
}

// The supply before each step says which voltage each current would find: the cell's own.
void ExpectTheVoltageOfTheCell(const Cell& cell, double tolerance_V) {
  BatterySupply battery(cell, 0.9);
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(0.9);
  const auto step = model.MakeStep(kFlightStep_s);
  double last_A = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const auto supply = battery.Linearize();
    for (const double current_A : {last_A, 0.0, 3.0, -1.0}) {
      ASSERT_NEAR(At(supply, current_A), model.Voltage(state, current_A), tolerance_V)
          << "step " << k << ", " << current_A << " A";
    }
    last_A = Current_A(k);
    battery.Advance(last_A * kFlightStep_s, kFlightStep_s);
    model.Advance(state, last_A, step);
    ASSERT_NEAR(battery.soc(), model.Soc(state, last_A), 1e-12);
  }
}

TEST(BatterySupply, HasTheVoltageOfTheCellAtEveryCurrent) {
  ExpectTheVoltageOfTheCell(StraightCell(), kRounding_V);
}

// In the cold with every term that knows temperature, the pack warming as it flies.
TEST(BatterySupply, HasItInTheCold) {
  Cell cell = StraightCell();
  cell.branches = {{Resistance<double>(0.03), 45.0, {}}};
  cell.charge_transfer = Cell::ChargeTransfer{.current_A = 1e8, .resistance_Ohm = 0.02};
  Cell::Temperature& term = cell.temperature.emplace();
  term.series_J_per_mol = 20e3;
  term.branches_J_per_mol = {40e3};
  term.diffusion_J_per_mol = 40e3;
  term.charge_transfer_J_per_mol = 60e3;
  term.entropy = EntropySlope<double>{{}, {2e-4}};
  term.heat = HeatBalance<double>{15.0, 20.0};
  cell.hysteresis = Cell::Hysteresis{20.0, {}, {0.01}};
  BatterySupply battery(cell, 0.9, -15.0);
  const CellModel<double> model(cell.Parameters());
  auto state = StartAmong(model, 0.9, {.ambient_degC = -15.0});
  CellModel<double>::Step step;
  for (int k = 0; k < 2000; ++k) {
    const auto supply = battery.Linearize();
    for (const double current_A : {0.0, 3.0, -1.0})
      ASSERT_NEAR(At(supply, current_A), model.Voltage(state, current_A), 1e-8) << k;
    battery.Advance(Current_A(k) * kFlightStep_s, kFlightStep_s);
    model.Prepare(step, kFlightStep_s, state);
    model.Advance(state, Current_A(k), step);
    ASSERT_NEAR(battery.temperature_degC(), state.temperature_K - 273.15, 1e-9) << k;
  }
  EXPECT_GT(battery.temperature_degC(), -14.9) << "it warms";
}

TEST(BatterySupply, HasItWithoutTheTail) {
  Cell cell = StraightCell();
  cell.diffusion->tail = false;
  ExpectTheVoltageOfTheCell(cell, kRounding_V);
  // The tail is a resistance: slope of the curve times what the modes beyond M hold back.
  const double r_tail = BatterySupply(StraightCell(), 0.9).Linearize().resistance_Ohm - 0.13;
  double sum = std::numbers::pi * std::numbers::pi / 6.0;
  for (int m = 1; m <= 10; ++m) sum -= 1.0 / (m * m);
  EXPECT_NEAR(r_tail, 1.0 * 2.0 * sum / (0.1924 * 0.1924 * 1353.6), 1e-14);
  EXPECT_EQ(BatterySupply(cell, 0.9).Linearize().resistance_Ohm, 0.13);
}

TEST(BatterySupply, HasItWithoutDiffusion) {
  Cell cell = StraightCell();
  cell.diffusion.reset();
  ExpectTheVoltageOfTheCell(cell, kRounding_V);
}

// A table of resistances is read at the A of the last current: exact for that current.
TEST(BatterySupply, HasItAtTheLastCurrentWithTablesOfResistance) {
  Cell cell = StraightCell();
  cell.series_resistance_Ohm = {{0.2, 0.6, 0.9}, {0.25, 0.15, 0.12}};
  cell.branches[0].resistance_Ohm = {{0.0, 1.0}, {0.1, 0.02}};
  BatterySupply battery(cell, 0.9);
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(0.9);
  const auto step = model.MakeStep(kFlightStep_s);
  for (int k = 0; k < 2000; ++k) {
    const double current_A = Current_A(k);
    battery.Advance(current_A * kFlightStep_s, kFlightStep_s);
    model.Advance(state, current_A, step);
    ASSERT_NEAR(At(battery.Linearize(), current_A), model.Voltage(state, current_A), kRounding_V)
        << k;
  }
}

// Warmth is a state like the others: between two steps the supply is still exact at any current.
TEST(BatterySupply, HasItWithSelfHeating) {
  Cell cell = StraightCell();
  cell.self_heating = {.time_constant_s = 3.0, .resistance_drop_Ohm_per_A2 = 6e-3};
  ExpectTheVoltageOfTheCell(cell, kRounding_V);
}

Cell CellWithTerms() {
  Cell cell = StraightCell();
  cell.self_heating = {.time_constant_s = 3.0, .resistance_drop_Ohm_per_A2 = 6e-3};
  cell.charge_transfer = {.current_A = 0.4, .resistance_Ohm = {{0.0, 1.0}, {0.1, 0.05}}};
  return cell;
}

// The drop of charge transfer is its tangent: exact at the last current, and off by half its second
// derivative elsewhere. With x = i/i_0 that is r_ct/i_0 x/(1 + x²)^1.5, at most 0.385 r_ct/i_0.
TEST(BatterySupply, TakesChargeTransferByItsTangent) {
  Cell cell = CellWithTerms();
  cell.charge_transfer->resistance_Ohm = {0.06};
  BatterySupply battery(cell, 0.9);
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(0.9);
  const auto step = model.MakeStep(kFlightStep_s);
  double farthest_V = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const double current_A = Current_A(k);
    battery.Advance(current_A * kFlightStep_s, kFlightStep_s);
    model.Advance(state, current_A, step);
    const auto supply = battery.Linearize();
    ASSERT_NEAR(At(supply, current_A), model.Voltage(state, current_A), kRounding_V) << k;
    for (const double aside_A : {-0.2, 0.2, 1.0}) {
      const double off_V =
          At(supply, current_A + aside_A) - model.Voltage(state, current_A + aside_A);
      farthest_V = std::max(farthest_V, std::abs(off_V));
      ASSERT_LE(std::abs(off_V), 0.5 * 0.385 * 0.06 / 0.4 * aside_A * aside_A + kRounding_V) << k;
    }
  }
  EXPECT_GT(farthest_V, 1e-3);
}

// On a bent curve the straight line holds at the last current, on whichever side of the bend.
TEST(BatterySupply, HasItAtTheLastCurrentAcrossTheBendsOfACurve) {
  Cell cell = StraightCell();
  cell.open_circuit_voltage =
      OpenCircuitVoltage::Linear({0.0, 0.3, 0.88, 0.89, 1.0}, {3.0, 3.7, 3.9, 4.05, 4.2});
  BatterySupply battery(cell, 0.9);
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(0.9);
  const auto step = model.MakeStep(kFlightStep_s);
  double lowest = 1.0;
  for (int k = 0; k < 4000; ++k) {
    const double current_A = Current_A(k);
    battery.Advance(current_A * kFlightStep_s, kFlightStep_s);
    model.Advance(state, current_A, step);
    lowest = std::min(lowest, battery.soc());
    ASSERT_NEAR(At(battery.Linearize(), current_A), model.Voltage(state, current_A), kRounding_V)
        << k;
  }
  EXPECT_LT(lowest, 0.88);
  // Expect() says for which current the line is to be right, without moving the cell.
  battery.Expect(5.0);
  EXPECT_NEAR(At(battery.Linearize(), 5.0), model.Voltage(state, 5.0), kRounding_V);
}

// Where the curve falls with A the tail would be a negative resistance: it is left out, and the
// voltage at the last current is still the cell's.
TEST(BatterySupply, LeavesOutATailThatWouldBeANegativeResistance) {
  Cell cell = StraightCell();
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.0, 3.9});
  BatterySupply battery(cell, 0.9);
  const CellModel<double> model(cell.Parameters());
  auto state = model.Relaxed(0.9);
  battery.Advance(3.0 * kFlightStep_s, kFlightStep_s);
  model.Advance(state, 3.0, model.MakeStep(kFlightStep_s));
  EXPECT_EQ(battery.Linearize().resistance_Ohm, 0.13);
  EXPECT_NEAR(At(battery.Linearize(), 3.0), model.Voltage(state, 3.0), kRounding_V);
}

// Battery and motors solved together: the closed form is the voltage at which the whole cell, tail
// and all, gives the current that four motors take.
TEST(BatterySupply, TheLoopWithTheMotorsIsTheRootOfTheWholeCell) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  const PerMotor<double> duty{0.5, 0.6, 0.7, 0.55};
  const PerMotor<double> speed{1900.0, 2100.0, 2000.0, 1700.0};
  for (const int parallel : {1, 3}) {
    Cell cell = StraightCell();
    cell.parallel = parallel;
    BatterySupply battery(cell, 0.9);
    const CellModel<double> model(cell.Parameters());
    auto state = model.Relaxed(0.9);
    const auto step = model.MakeStep(kFlightStep_s);
    for (int k = 0; k < 500; ++k) {
      battery.Advance(parallel * Current_A(k) * kFlightStep_s, kFlightStep_s);
      model.Advance(state, Current_A(k), step);
    }
    const auto surplus = [&](double volts) {
      double pack_A = 0.0;
      for (std::size_t i = 0; i < 4; ++i) {
        pack_A += duty[i] * (duty[i] * volts - v.motor_constant_N_m_per_A * speed[i]) /
                  v.armature_resistance_Ohm;
      }
      return model.Voltage(state, pack_A / parallel) - volts;
    };
    std::uintmax_t iterations = 200;
    const auto root = boost::math::tools::toms748_solve(
        surplus, 0.0, 10.0, boost::math::tools::eps_tolerance<double>(52), iterations);
    EXPECT_NEAR(LoopVoltage(v, battery.Linearize(), duty, speed), root.first, 1e-13);
  }
}

// The same with charge transfer: no closed form, but tangents that move to the current they find
// end at the root of the whole cell, as Newton's method does.
TEST(BatterySupply, TangentsEndAtTheRootOfTheWholeCell) {
  const Vehicle v = LoadVehicle("mambo-coupled");
  const PerMotor<double> duty{0.5, 0.6, 0.7, 0.55};
  const PerMotor<double> speed{1900.0, 2100.0, 2000.0, 1700.0};
  for (const int parallel : {1, 3}) {
    Cell cell = CellWithTerms();
    cell.parallel = parallel;
    BatterySupply battery(cell, 0.9);
    const CellModel<double> model(cell.Parameters());
    auto state = model.Relaxed(0.9);
    const auto step = model.MakeStep(kFlightStep_s);
    for (int k = 0; k < 500; ++k) {
      battery.Advance(parallel * Current_A(k) * kFlightStep_s, kFlightStep_s);
      model.Advance(state, Current_A(k), step);
    }
    double voltage_V = 0.0;
    double pack_A = 0.0;
    for (int round = 0; round < 6; ++round) {
      voltage_V = LoopVoltage(v, battery.Linearize(), duty, speed);
      PerMotor<double> motor_A;
      for (std::size_t i = 0; i < 4; ++i)
        motor_A[i] = ArmatureCurrent(v, duty[i] * voltage_V, speed[i]);
      pack_A = BatteryCurrent(duty, motor_A);
      battery.Expect(pack_A);
    }
    // The answer put back into the cell's own equation; tables are read at the A of this current.
    EXPECT_NEAR(voltage_V, model.Voltage(state, pack_A / parallel), 1e-13) << parallel;
    EXPECT_GT(pack_A, 0.0);
  }
}

TEST(BatterySupply, APackIsItsCellsTimesSeriesAndOverParallel) {
  Cell pack_cell = CellWithTerms();
  pack_cell.series = 3;
  pack_cell.parallel = 2;
  BatterySupply pack(pack_cell, 0.8);
  BatterySupply single(CellWithTerms(), 0.8);
  EXPECT_EQ(pack.cutoff_V(), 9.0);
  EXPECT_EQ(pack.parallel(), 2.0);
  for (int k = 0; k < 500; ++k) {
    const double current_A = Current_A(k);
    pack.Advance(2.0 * current_A * kFlightStep_s, kFlightStep_s);
    single.Advance(current_A * kFlightStep_s, kFlightStep_s);
    ASSERT_NEAR(pack.soc(), single.soc(), 1e-14);
    ASSERT_NEAR(
        At(pack.Linearize(), 2.0 * 1.7), 3.0 * At(single.Linearize(), 1.7), 3.0 * kRounding_V);
  }
  pack.Expect(4.0);
  single.Expect(2.0);
  EXPECT_NEAR(pack.soc(), single.soc(), 1e-14);
}

// Charge balance: once everything has relaxed, A is what the charge that left says, however the
// steps were long.
TEST(BatterySupply, WhatLeavesIsMissing) {
  BatterySupply battery(StraightCell(), 1.0);
  double charge_C = 0.0;
  for (int k = 0; k < 1000; ++k) {
    const double dt_s = k % 3 == 0 ? 0.01 : kFlightStep_s;
    battery.Advance(Current_A(k) * dt_s, dt_s);
    charge_C += Current_A(k) * dt_s;
  }
  EXPECT_LT(battery.soc(), 1.0 - charge_C / 1353.6);  // some is held back
  battery.Advance(0.0, 3600.0);
  EXPECT_NEAR(battery.soc(), 1.0 - charge_C / 1353.6, 1e-13);
}

}  // namespace
}  // namespace lipoid
