#include "model/flight/endurance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/level_flight.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

// v_oc(A) = empty_V + (full_V - empty_V) A behind a resistance, without diffusion or branches.
Cell StraightCell(double empty_V, double full_V, double resistance_Ohm) {
  Cell cell;
  cell.name = "straight";
  cell.capacity_Ah = 1.0;
  cell.cutoff_V = 0.5 * empty_V;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {empty_V, full_V});
  cell.series_resistance_Ohm = resistance_Ohm;
  return cell;
}

EnduranceSetup At(Cell cell, double power_W) {
  EnduranceSetup setup;
  setup.cell = std::move(cell);
  setup.mission.legs = {{.power_W = power_W}};
  return setup;
}

// Half the first step's change of the current, and second order of the step afterwards: of a flight of
// 1000 s in 50,000 steps.
constexpr double kHeldCurrent = 1e-8;

TEST(Endurance, AnIdealCellGivesTheEnergyUnderItsCurve) {
  EnduranceSetup setup = At(StraightCell(3.2, 4.2, 0.0), 10.0);
  setup.reserve = 0.2;
  const EnduranceResult result = FlyMission(setup);
  EXPECT_EQ(result.ended_by, MissionEnd::kReserve);
  // The integral of v_oc over the charge from A = 1 to 0.2.
  const double energy_J = 3600.0 * (3.2 * 0.8 + 0.5 * (1.0 - 0.04));
  EXPECT_NEAR(result.time_s, energy_J / 10.0, kHeldCurrent * result.time_s);
  EXPECT_NEAR(result.energy_J, energy_J, kHeldCurrent * energy_J);
  EXPECT_NEAR(result.charge_C, 0.8 * 3600.0, 1e-6);
  EXPECT_NEAR(result.rest_soc, 0.2, 1e-12);
  EXPECT_NEAR(result.landing_voltage_V, 3.4, 1e-9);
  EXPECT_NEAR(result.landing_rest_voltage_V, 3.4, 1e-9);
}

TEST(Endurance, AConstantVoltageBehindAResistanceDrawsTheLowerRootOfThePower) {
  EnduranceSetup setup = At(StraightCell(4.0, 4.0, 0.1), 15.0);
  setup.cell.series = 3;
  setup.cell.parallel = 2;
  setup.reserve = 0.25;
  const EnduranceResult result = FlyMission(setup);
  // (12 - 0.15 i) i = 15
  const double current_A = (12.0 - std::sqrt(144.0 - 4.0 * 0.15 * 15.0)) / (2.0 * 0.15);
  EXPECT_NEAR(result.initial_current_A, current_A, 1e-12);
  EXPECT_NEAR(result.time_s, 0.75 * 7200.0 / current_A, 1e-6);
  EXPECT_NEAR(result.landing_voltage_V, 12.0 - 0.15 * current_A, 1e-9);
  EXPECT_NEAR(result.landing_rest_voltage_V, 12.0, 1e-9);
  EXPECT_NEAR(result.energy_J, 15.0 * result.time_s, 1e-6);
}

TEST(Endurance, EndsASecondAfterTheMotorsLackVoltage) {
  EnduranceSetup setup = At(StraightCell(3.2, 4.2, 0.0), 10.0);
  setup.options.step_s = 0.005;
  setup.mission.legs[0].least_V = 3.7;
  const EnduranceResult result = FlyMission(setup);
  EXPECT_EQ(result.ended_by, MissionEnd::kMotorVoltage);
  const double energy_J = 3600.0 * 0.5 * (4.2 + 3.7) * 0.5;
  // A second, up to one step.
  EXPECT_NEAR(result.time_s, energy_J / 10.0 + 1.0, setup.options.step_s);

  setup.mission.legs[0].least_V = 4.3;
  const EnduranceResult never = FlyMission(setup);
  EXPECT_EQ(never.ended_by, MissionEnd::kMotorVoltage);
  EXPECT_EQ(never.time_s, 0.0);
  EXPECT_EQ(never.charge_C, 0.0);
}

TEST(Endurance, EndsASecondAfterTheCutOff) {
  EnduranceSetup setup = At(StraightCell(3.2, 4.2, 0.0), 10.0);
  setup.options.step_s = 0.005;
  setup.cell.cutoff_V = 3.7;
  const EnduranceResult result = FlyMission(setup);
  EXPECT_EQ(result.ended_by, MissionEnd::kCutOff);
  EXPECT_NEAR(result.time_s, 3600.0 * 0.5 * (4.2 + 3.7) * 0.5 / 10.0 + 1.0, setup.options.step_s);
}

TEST(Endurance, ABatteryThatNeverGivesThePowerDoesNotTakeOff) {
  // E²/(4 R) = 22.05 W is the most.
  const EnduranceResult result = FlyMission(At(StraightCell(3.2, 4.2, 0.2), 22.1));
  EXPECT_EQ(result.ended_by, MissionEnd::kPower);
  EXPECT_EQ(result.time_s, 0.0);
  EXPECT_NEAR(result.landing_voltage_V, 2.1, 1e-12);
  EXPECT_GT(FlyMission(At(StraightCell(3.2, 4.2, 0.2), 22.0)).time_s, 0.0);
}

// A power that no current gives ends a flight after a second, at its beginning as later.
TEST(Endurance, APeakBeyondTheBatteryIsNoted) {
  EnduranceSetup setup = At(StraightCell(3.2, 4.2, 0.2), 1.0);
  setup.mission.legs = {{.duration_s = 0.05, .power_W = 100.0},
                        {.duration_s = 60.0, .power_W = 1.0}};
  setup.mission.repeats = false;
  const EnduranceResult first = FlyMission(setup);
  EXPECT_EQ(first.ended_by, MissionEnd::kMissionDone);
  ASSERT_TRUE(first.lack);
  EXPECT_EQ(first.lack->since_s, 0.0);
  EXPECT_EQ(first.lack->power_W, 100.0);
  EXPECT_NEAR(first.lack->most_W, 4.2 * 4.2 / (4.0 * 0.2), 1e-9);  // E²/(4 R)
  EXPECT_NEAR(first.lack_s, 0.05, 1e-12);

  // The peaks come again each round; what ends the flight is the long one.
  setup.mission.repeats = true;
  setup.mission.legs.push_back({.duration_s = 2.0, .power_W = 30.0});
  const EnduranceResult later = FlyMission(setup);
  EXPECT_EQ(later.ended_by, MissionEnd::kPower);
  EXPECT_NEAR(later.lack->since_s, 60.05, 1e-9);
  EXPECT_EQ(later.lack->power_W, 30.0);
  EXPECT_NEAR(later.time_s, 61.05, setup.options.step_s + 0.1);

  // An answer that always had its power has none.
  setup.mission.legs = {{.duration_s = 60.0, .power_W = 1.0}};
  setup.mission.repeats = false;
  EXPECT_FALSE(FlyMission(setup).lack);
}

// A power that no current gives is not a charge that was used up, also where the current that comes
// nearest to it takes A to 0.
TEST(Endurance, APeakThatEmptiesADiffusingCellEndsByItsPower) {
  EnduranceSetup setup = At(LoadCell("gifi-600mAh-1"), 1.0);
  setup.initial_soc = 0.25;
  setup.mission.legs = {{.duration_s = 0.05, .power_W = 1.0},
                        {.duration_s = 0.05, .power_W = 2000.0},
                        {.duration_s = 59.9, .power_W = 1.0}};
  const EnduranceResult result = FlyMission(setup);
  EXPECT_EQ(result.ended_by, MissionEnd::kPower);
  EXPECT_EQ(result.lack->power_W, 2000.0);
  EXPECT_NEAR(std::fmod(result.lack->since_s, 60.0), 0.05, 1e-6);  // sums of 0.05 and 59.9
}

// Diffusion holds charge back, which is there again after a rest.
TEST(Endurance, TheChargeThatDiffusionHoldsBackIsNotUsedUp) {
  EnduranceSetup setup = At(StraightCell(3.2, 4.2, 0.0), 10.0);
  setup.cell.diffusion = Cell::Diffusion{.alpha_C = 3600.0, .beta_per_sqrt_s = 0.1};
  const EnduranceResult result = FlyMission(setup);
  EXPECT_EQ(result.ended_by, MissionEnd::kEmpty);
  EXPECT_NEAR(result.soc, 0.0, 1e-4);
  // i pi²/(3 beta²) in the steady state; the current grows by a tenth within the time constant of
  // the slowest mode, 100 s.
  const double held_C = 10.0 / 3.2 * std::numbers::pi * std::numbers::pi / (3.0 * 0.01);
  EXPECT_NEAR(result.rest_soc * 3600.0, held_C, 0.05 * held_C);
}

// Resistance, branches and diffusion only lower the voltage of a battery that is discharged, so that
// no pack gives more under load than it has at rest, however small it is.
TEST(Endurance, NoBatteryGivesMoreUnderLoadThanAtRest) {
  EnduranceSetup setup = At(LoadCell("grepow-32Ah-1"), 52.0);
  const double alpha_C = setup.cell.diffusion->alpha_C;
  for (const double capacity_Ah : {5.2, 0.5, 0.26, 0.15, 0.1, 0.07, 0.052, 0.04, 0.02, 0.005}) {
    SCOPED_TRACE(capacity_Ah);
    setup.cell.diffusion->alpha_C = alpha_C * capacity_Ah / 32.0;
    const EnduranceResult result = FlyMission(setup);
    EXPECT_LE(result.initial_voltage_V, 4.2);
    EXPECT_LE(result.landing_voltage_V, result.landing_rest_voltage_V);
    EXPECT_GT(result.landing_voltage_V, 0.0);
    EXPECT_LE(result.landing_rest_voltage_V, 4.2);
    const std::vector<EnduranceSetup> two(2, setup);
    for (const EnduranceResult& beside : FlyMissions(two))
      EXPECT_NEAR(beside.landing_voltage_V, result.landing_voltage_V, 1e-6);
  }
}

TEST(Endurance, AMissionRepeatsOrIsFlownOnce) {
  EnduranceSetup setup = At(StraightCell(4.0, 4.0, 0.0), 0.0);
  setup.mission.legs = {{.duration_s = 10.001, .power_W = 20.0},
                        {.duration_s = 5.0, .power_W = 4.0},
                        {.duration_s = 0.0003, .power_W = -8.0}};
  setup.mission.repeats = false;
  const EnduranceResult once = FlyMission(setup);
  EXPECT_EQ(once.ended_by, MissionEnd::kMissionDone);
  EXPECT_EQ(once.rounds, 1);
  EXPECT_NEAR(once.time_s, 15.0013, 1e-9);
  const double round_C = (10.001 * 20.0 + 5.0 * 4.0 - 0.0003 * 8.0) / 4.0;
  EXPECT_NEAR(once.charge_C, round_C, 1e-9);
  EXPECT_NEAR(once.peak_current_A, 5.0, 1e-12);

  setup.mission.repeats = true;
  setup.reserve = 0.1;
  const EnduranceResult all = FlyMission(setup);
  EXPECT_EQ(all.ended_by, MissionEnd::kReserve);
  EXPECT_EQ(all.rounds, static_cast<int>(0.9 * 3600.0 / round_C));
  EXPECT_NEAR(all.charge_C, 0.9 * 3600.0, 1e-6);
}

// A constant heat into one lump of heat capacity behind a thermal resistance.
TEST(Endurance, ItsHeatWarmsTheCell) {
  EnduranceSetup setup = At(StraightCell(4.0, 4.0, 0.1), 12.0);
  setup.reserve = 0.5;
  setup.ambient_degC = 10.0;
  setup.cell.temperature.emplace().heat =
      HeatBalance<double>{.heat_capacity_J_per_K = 40.0, .thermal_resistance_K_per_W = 8.0};
  const EnduranceResult result = FlyMission(setup);
  const double current_A = (4.0 - std::sqrt(16.0 - 0.4 * 12.0)) / 0.2;
  const double settled_K = 0.1 * current_A * current_A * 8.0;
  EXPECT_NEAR(
      result.hottest_degC, 10.0 - settled_K * std::expm1(-result.time_s / (8.0 * 40.0)), 1e-9);
  EXPECT_TRUE(std::isnan(FlyMission(At(StraightCell(4.0, 4.0, 0.1), 12.0)).hottest_degC));
}

// The drop of charge transfer bends, so the current is the root of P = i v(i) at every step.
TEST(Endurance, ThePowerIsThatOfTheCellsOwnVoltage) {
  EnduranceSetup setup = At(LoadCell("gifi-600mAh-1"), 9.0);
  setup.cell.charge_transfer = {.current_A = 0.4, .resistance_Ohm = {{0.0, 0.5}, {0.09, 0.04}}};
  const EnduranceResult result = FlyMission(setup);
  const CellModel<double> model(setup.cell.Parameters());
  EXPECT_NEAR(
      model.Voltage(model.Relaxed(1.0), result.initial_current_A) * result.initial_current_A,
      9.0,
      1e-9);
  EXPECT_NEAR(result.energy_J, 9.0 * result.time_s, 1e-6 * result.energy_J);
}

// Of second order: halving the step divides the error by four, up to the end of the flight and the
// kinks of the curve, which fall somewhere within a step.
TEST(Endurance, TheErrorOfAStepIsOfSecondOrder) {
  EnduranceSetup setup = At(LoadCell("gifi-600mAh-1"), 9.0);
  setup.reserve = 0.4;
  const auto time_s = [&](double step_s) {
    setup.options.step_s = step_s;
    return FlyMission(setup).time_s;
  };
  const double exact_s = time_s(0.005);
  EXPECT_NEAR(time_s(0.01), exact_s, 1e-7 * exact_s);
  EXPECT_NEAR(time_s(1.0), exact_s, 1e-4 * exact_s);
  EXPECT_NEAR(time_s(0.1), exact_s, 1e-6 * exact_s);
}

// Side by side or one after the other, for each way in which a cell may differ that fits into lanes;
// two of them do not.
TEST(Endurance, FlightsSideBySideAreThoseOneAfterTheOther) {
  std::vector<EnduranceSetup> setups;
  const auto add = [&](Cell cell, double power_W, double reserve) {
    setups.push_back(At(std::move(cell), power_W));
    setups.back().reserve = reserve;
    setups.back().options.step_s = 0.02;
  };
  Cell cell = LoadCell("gifi-600mAh-1");
  add(cell, 9.0, 0.0);
  add(cell, 11.0, 0.5);
  setups.back().mission.legs[0].drive_W = 1.0;
  setups.back().mission.legs[0].switched_A = 0.1;
  setups.back().mission.legs[0].ground_speed_m_per_s = 3.0;
  add(cell, 9.0, 0.1);
  setups.back().mission.legs[0].least_V = 3.6;
  cell.series_resistance_Ohm = {{0.0, 0.35, 0.8}, {0.2, 0.13, 0.12}};
  add(cell, 9.0, 0.2);
  cell.open_circuit_voltage =
      OpenCircuitVoltage::MonotoneCubic({0.0, 0.1, 0.5, 0.8, 1.0}, {3.0, 3.6, 3.8, 4.0, 4.2});
  cell.branches[0] = {
      .resistance_Ohm = {{0.0, 1.0}, {0.1, 0.02}}, .time_constant_s = 20.0, .capacitance_F = {}};
  add(cell, 8.0, 0.2);
  cell.series = 3;
  cell.parallel = 2;
  cell.diffusion->beta_per_sqrt_s = 0.1;
  add(cell, 40.0, 0.0);
  add(cell, 400.0, 0.0);  // never takes off
  cell.charge_transfer = {.current_A = 0.4, .resistance_Ohm = 0.02};
  add(cell, 40.0, 0.3);  // does not fit
  add(cell, 40.0, 0.3);
  setups.back().cell.charge_transfer.reset();
  setups.back().options.longest_s = 100.0;
  // Of the tables the tangent at the last current is taken, without a search for the present one's.
  constexpr double kTangent = 1e-6;
  const auto beside = FlyMissions(setups);
  ASSERT_EQ(beside.size(), setups.size());
  std::set<MissionEnd> ends;
  for (std::size_t k = 0; k < setups.size(); ++k) {
    const EnduranceResult alone = FlyMission(setups[k]);
    ends.insert(alone.ended_by);
    EXPECT_EQ(beside[k].ended_by, alone.ended_by) << k;
    const auto near = [&](double EnduranceResult::*number) {
      // What never took off has no lowest voltage and no highest current, either way.
      if (std::isnan(alone.*number)) {
        EXPECT_TRUE(std::isnan(beside[k].*number)) << k;
        return;
      }
      EXPECT_NEAR(beside[k].*number, alone.*number, kTangent * (1.0 + alone.*number)) << k;
    };
    near(&EnduranceResult::charge_C);
    near(&EnduranceResult::energy_J);
    near(&EnduranceResult::landing_voltage_V);
    near(&EnduranceResult::landing_rest_voltage_V);
    near(&EnduranceResult::minimum_voltage_V);
    near(&EnduranceResult::peak_current_A);
    near(&EnduranceResult::initial_current_A);
    near(&EnduranceResult::distance_m);
    near(&EnduranceResult::soc);
    // The cut-off is found up to a step.
    EXPECT_NEAR(beside[k].time_s, alone.time_s, 1e-6 * alone.time_s + 1e-9) << k;
  }
  EXPECT_GE(ends.size(), 5U);
}

// Flown until the cell has gone below its table, whose lowest piece is flat; the top is flat too.
TEST(Endurance, FlatEndsOfTheCurveAreTheSameSideBySide) {
  const std::vector<double> soc{0.05, 0.1, 0.3, 0.9, 1.0};
  const std::vector<double> voltage_V{3.4, 3.4, 3.6, 4.15, 4.15};
  for (const bool lines : {true, false}) {
    EnduranceSetup setup = At(LoadCell("gifi-600mAh-1"), 1.0);
    setup.cell.open_circuit_voltage = lines ? OpenCircuitVoltage::Linear(soc, voltage_V)
                                            : OpenCircuitVoltage::MonotoneCubic(soc, voltage_V);
    setup.reserve = 0.01;
    setup.options.step_s = 0.1;
    const EnduranceResult alone = FlyMission(setup);
    const auto beside = FlyMissions(std::vector<EnduranceSetup>{setup, setup});
    EXPECT_LT(alone.soc, 0.02);
    EXPECT_NEAR(beside[0].energy_J, alone.energy_J, 1e-6 * alone.energy_J) << lines;
    EXPECT_NEAR(beside[0].landing_voltage_V, alone.landing_voltage_V, 1e-6) << lines;
    EXPECT_NEAR(beside[0].time_s, alone.time_s, 1e-6 * alone.time_s) << lines;
  }
}

// A flight is the same bits whatever flies beside it.
TEST(Endurance, WhatFliesBesideDoesNotMatter) {
  std::vector<EnduranceSetup> setups;
  for (const double power_W : {9.0, 10.0, 11.0}) {
    setups.push_back(At(LoadCell("gifi-600mAh-1"), power_W));
    setups.back().reserve = 0.5;
    setups.back().options.step_s = 0.1;
  }
  const auto three = FlyMissions(setups);
  for (std::size_t k = 0; k < setups.size(); ++k) {
    const auto one = FlyMissions(std::span(setups).subspan(k, 1));
    EXPECT_EQ(one[0].time_s, three[k].time_s) << k;
    EXPECT_EQ(one[0].landing_voltage_V, three[k].landing_voltage_V) << k;
    EXPECT_EQ(one[0].energy_J, three[k].energy_J) << k;
  }
}

// Diodes and switching: the current is the root of i v = P(v).
TEST(Endurance, TheLoadFollowsTheVoltage) {
  EnduranceSetup setup = At(StraightCell(4.0, 4.0, 0.1), 2.0);
  setup.mission.legs[0].drive_W = 9.0;
  setup.mission.legs[0].diode_V = 0.6;
  setup.mission.legs[0].switched_A = 0.2;
  setup.reserve = 0.5;
  const EnduranceResult result = FlyMission(setup);
  const double v = result.initial_voltage_V;
  EXPECT_NEAR(v, 4.0 - 0.1 * result.initial_current_A, 1e-12);
  EXPECT_NEAR(result.initial_current_A * v, 2.0 + 9.0 * v / (v + 0.6) + 0.2 * v, 1e-8);
  EXPECT_NEAR(result.time_s, 0.5 * 3600.0 / result.initial_current_A, 1e-5);
}

// The simulator holds the height by its controller, whose vehicle sinks by centimetres as the voltage
// falls: it takes a little less power for it.
TEST(Endurance, AgreesWithTheFlightSimulator) {
  constexpr double kSinking = 1e-3;
  for (const char* name : {"mambo-coupled", "mambo-physical"}) {
    FlightSetup flown;
    flown.vehicle = LoadVehicle(name);
    flown.cell = LoadCell("gifi-600mAh-1");
    flown.gains = LoadGains("aware");
    const FlightResult flight = Fly(flown, FindManeuver("endurance").plan({}));
    ASSERT_EQ(flight.outcome, Outcome::kBatteryEmpty);
    const LevelFlight hover = Cruise(flown.vehicle, 0.0);
    EnduranceSetup setup = At(*flown.cell, BatteryPower(flown.vehicle, hover, 1.0));
    setup.mission.legs[0].least_V = hover.battery_V;
    const EnduranceResult result = FlyMission(setup);
    EXPECT_EQ(result.ended_by, MissionEnd::kCutOff) << name;
    EXPECT_NEAR(result.time_s, flight.simulated_s, kSinking * flight.simulated_s) << name;
    EXPECT_NEAR(result.charge_C, flight.charge_C, kSinking * flight.charge_C) << name;
    EXPECT_NEAR(result.initial_current_A, flight.trim.battery_A, 1e-9) << name;
  }
}

TEST(Endurance, WantsLegsThatLast) {
  EnduranceSetup setup = At(StraightCell(4.0, 4.0, 0.1), 1.0);
  setup.mission.legs[0].duration_s = 0.0;
  EXPECT_THROW((void)FlyMission(setup), PreconditionError);
  setup.mission.legs.clear();
  EXPECT_THROW((void)FlyMission(setup), PreconditionError);
}

TEST(Endurance, ABatteryThatIsNeverEmptyMeetsTheTimeLimit) {
  EnduranceSetup setup = At(StraightCell(4.0, 4.0, 0.1), 0.0);
  setup.options.longest_s = 100.0;
  const EnduranceResult result = FlyMission(setup);
  EXPECT_EQ(result.ended_by, MissionEnd::kTimeLimit);
  EXPECT_NEAR(result.time_s, 100.0, 1e-6);
}

}  // namespace
}  // namespace lipoid
