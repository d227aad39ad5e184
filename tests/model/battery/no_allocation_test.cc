// What is called per 5 ms of flight or per row of a log must not allocate: the cell, the wind, the
// sensors and the estimator. This file replaces the global operator new of the test program by one
// that counts.

#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "model/battery/cell_file.h"
#include "model/battery/cell_model.h"
#include "model/battery/record_stepper.h"
#include "model/control/estimator.h"
#include "model/control/flight_controller.h"
#include "model/vehicle/battery_supply.h"
#include "model/vehicle/plant.h"
#include "model/vehicle/sensors.h"
#include "model/vehicle/vehicle_file.h"
#include "model/vehicle/wind.h"
#include "tests/support/sanitized.h"

// A sanitizer brings operators of its own, which must not be replaced.
#ifdef LIPOID_SANITIZED

TEST(NoAllocation, IsCountedInOtherBuilds) {
  GTEST_SKIP() << "skipped: the address sanitizer has its own operator new";
}

#else

namespace {
std::size_t allocations = 0;  // tests run one at a time
}  // namespace

// Not inlined: at -O3 GCC 12 sees the free() of one half beside the other half, as it stands before
// inlining, and calls them mismatched (-Wmismatched-new-delete).
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace lipoid {
namespace {

CellParameters<double> LargeCell() {
  CellParameters<double> cell;
  cell.alpha_C = 1353.6;
  cell.beta_per_sqrt_s = 0.1924;
  cell.terms = 50;
  cell.series_resistance_Ohm = Resistance<double>({0.0, 1.0}, {0.2, 0.1});
  cell.branches = {{0.03, 45.0}, {Resistance<double>({0.0, 0.5, 1.0}, {0.1, 0.2, 0.3}), 2.0}};
  cell.open_circuit_voltage =
      OpenCircuitVoltage::MonotoneCubic({0.0, 0.1, 0.5, 0.8, 1.0}, {3.0, 3.6, 3.8, 4.0, 4.2});
  cell.self_heating = {300.0, 1e-3};
  cell.charge_transfer = {0.5, Resistance<double>({0.0, 1.0}, {0.1, 0.05})};
  return cell;
}

TEST(NoAllocation, TheCounterCounts) {
  const std::size_t before = allocations;
  const std::vector<double> one(10);
  EXPECT_GT(allocations, before) << one.size();
}

TEST(NoAllocation, InTheStepAndTheVoltageOfACell) {
  const CellModel<double> model(LargeCell());
  auto state = model.Relaxed(1.0);
  const auto step = model.MakeStep(0.005);
  double lowest_V = 5.0;
  const std::size_t before = allocations;
  for (int k = 0; k < 1000; ++k) {
    model.Advance(state, 3.0, step);
    lowest_V = std::min(lowest_V, model.Voltage(state, 3.0));
  }
  EXPECT_EQ(allocations, before);
  EXPECT_LT(lowest_V, 4.0);
}

TEST(NoAllocation, PerRowOfARecordOnceItsIntervalsAreKnown) {
  const CellModel<double> model(LargeCell());
  RecordStepper<double> stepper(model, Hold::kBackward, model.Relaxed(1.0));
  for (int k = 0; k < 10; ++k) stepper.Row(0.01 * k, 1.0);
  const std::size_t before = allocations;
  for (int k = 10; k < 1000; ++k) stepper.Row(0.01 * k, 1.0);
  // A rounded stamp may fall into the neighbouring slot once: its two vectors.
  EXPECT_LE(allocations - before, 4U);
}

TEST(NoAllocation, InTheBatteryOfAFlightAndItsPlant) {
  BatterySupply battery(LoadCell("gifi-600mAh-1"), 0.9);
  const Plant plant(LoadVehicle("mambo-coupled"), {});
  PlantState<double> x{};
  PlantState<double> dx{};
  PlantInputs<double> in{.duty = {0.5, 0.5, 0.5, 0.5}};
  const std::size_t before = allocations;
  for (int k = 0; k < 1000; ++k) {
    in.supply = battery.Linearize();
    plant.Derivative(x, in, dx);
    battery.Advance(0.005 * dx[plant::kCharge], 0.005);
  }
  EXPECT_EQ(allocations, before);
  EXPECT_LT(battery.soc(), 0.9);
}

TEST(NoAllocation, InTheStepOfWindSensorsAndEstimator) {
  WindOptions gusty;
  gusty.gusts_m_per_s = 5.0;
  Wind wind(gusty, 1);
  Sensors sensors({}, 1);
  Estimator estimator({});
  SensedMotion motion;
  motion.position_m[2] = -1.5;
  motion.specific_force_m_per_s2[2] = -9.81;
  estimator.Reset({.position_m = motion.position_m}, {});
  MeasuredState state;
  const std::size_t before = allocations;
  for (int k = 0; k < 1000; ++k) {
    motion.velocity_m_per_s = wind.Step(1.5 + 1e-3 * k, 2.0);
    SensorReadings readings = sensors.Read(motion);
    if (k % 50 == 0) readings.sonar_m = 9.0;
    state = estimator.Step(readings);
  }
  EXPECT_EQ(allocations, before);
  EXPECT_NE(state.velocity_m_per_s[0], 0.0);
}

TEST(NoAllocation, InTheStepOfAFlightController) {
  FlightController controller(LoadVehicle("mambo-coupled"), LoadGains("aware"), {});
  MeasuredState state;
  state.position_m[2] = -1.0;
  state.battery_V = 3.8;
  controller.Reset(state, 2000.0, 2700.0);
  double sum = 0.0;
  const std::size_t before = allocations;
  for (int k = 0; k < 1000; ++k) {
    state.angles_rad[0] = 1e-4 * k;  // into saturation
    sum += controller.Step({.altitude_m = 1.5, .x_m = 1.0}, state)[0];
  }
  EXPECT_EQ(allocations, before);
  EXPECT_GT(sum, 0.0);
}

}  // namespace
}  // namespace lipoid

#endif
