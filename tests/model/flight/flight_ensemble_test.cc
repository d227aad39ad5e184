#include "model/flight/flight_ensemble.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

FlightSetup CoupledUncertain() {
  FlightSetup setup;
  setup.vehicle = LoadVehicle("mambo-coupled");
  setup.cell = LoadCell("gifi-600mAh-1");
  setup.cell->uncertainty =
      Cell::Uncertainty{.parameters = {"r_s"}, .covariance = {{4e-4}}, .degrees_of_freedom = 1e7};
  setup.gains = LoadGains("aware");
  setup.estimate = true;  // noise of the sensors takes part
  setup.seed = 5;
  return setup;
}

FlightPlan Steps() {
  FlightPlan plan = AltitudeSteps().plan({});
  plan.duration_s = 12.0;
  return plan;
}

TEST(FlightEnsemble, EachFlightIsThatOfItsCellOnAnyNumberOfThreads) {
  const FlightSetup setup = CoupledUncertain();
  const auto cells = DrawCells(*setup.cell, 4, 1).cells;
  const std::vector<double> soc{1.0, 0.9, 0.8, 1.0};
  std::atomic<int> told = 0;
  const auto flights = FlyOnEach(setup, Steps(), cells, soc, [&](double) { ++told; });
  ASSERT_EQ(flights.size(), 4U);
  EXPECT_EQ(told, 4);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const auto again = FlyOnEach(setup, Steps(), cells, soc);
  for (std::size_t k = 0; k < cells.size(); ++k) {
    FlightSetup own = setup;
    own.cell = cells[k];
    own.initial_soc = soc[k];
    const FlightResult alone = Fly(own, Steps());
    EXPECT_EQ(flights[k].minimum_voltage_V, alone.minimum_voltage_V) << k;
    EXPECT_EQ(flights[k].mse_altitude_m2, alone.mse_altitude_m2) << k;
    EXPECT_EQ(again[k].minimum_voltage_V, alone.minimum_voltage_V) << k;
    EXPECT_EQ(again[k].charge_C, alone.charge_C) << k;
  }
  EXPECT_NE(flights[0].minimum_voltage_V, flights[3].minimum_voltage_V);
}

TEST(FlightEnsemble, OutcomesAreCountedAndNumbersHaveIntervals) {
  std::vector<FlightResult> flights(5);
  for (std::size_t k = 0; k < 5; ++k) flights[k].final_soc = 0.1 * static_cast<double>(k);
  flights[1].outcome = Outcome::kCrashed;
  flights[2].outcome = Outcome::kBatteryEmpty;
  flights[4].outcome = Outcome::kCrashed;
  flights[4].final_soc = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(CountOf(flights, Outcome::kCompleted), 2);
  EXPECT_EQ(CountOf(flights, Outcome::kCrashed), 2);
  EXPECT_EQ(CountOf(flights, Outcome::kBatteryEmpty), 1);
  const auto [low, high] = IntervalOf(flights, &FlightResult::final_soc);
  EXPECT_EQ(low, 0.0);
  EXPECT_EQ(high, 0.1 * 3.0);
}

// More resistance, less voltage: the interval of the lowest voltage is that of r_s.
TEST(FlightEnsemble, AnUncertainResistanceIsAnUncertainVoltage) {
  const FlightSetup setup = CoupledUncertain();
  const auto ensemble = DrawCells(*setup.cell, 12, 1);
  const auto flights = FlyOnEach(setup, Steps(), ensemble.cells, std::vector<double>(12, 1.0));
  std::vector<std::pair<double, double>> by_resistance;
  for (std::size_t k = 0; k < flights.size(); ++k)
    by_resistance.emplace_back(ensemble.cells[k].series_resistance_Ohm.resistance_Ohm[0],
                               flights[k].minimum_voltage_V);
  std::sort(by_resistance.begin(), by_resistance.end());
  for (std::size_t k = 1; k < by_resistance.size(); ++k)
    EXPECT_LT(by_resistance[k].second, by_resistance[k - 1].second);
  const auto [low, high] = IntervalOf(flights, &FlightResult::minimum_voltage_V);
  EXPECT_EQ(low, by_resistance.back().second);
  EXPECT_EQ(high, by_resistance.front().second);
}

}  // namespace
}  // namespace lipoid
