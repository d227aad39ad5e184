#include "model/flight/endurance_request.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <cmath>

#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/core/errors.h"
#include "model/flight/endurance_report.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

EnduranceRequest MamboOfCoarseSteps() {
  EnduranceRequest request;
  request.vehicle = LoadVehicle("mambo-physical");
  request.cell = LoadCell("gifi-600mAh-1");
  request.options.step_s = 0.1;
  request.seed = 3;
  return request;
}

// A constant voltage without resistance: time is reserve, capacity and power in closed form.
EnduranceRequest Simple() {
  EnduranceRequest request;
  request.cell.capacity_Ah = 1.0;
  request.cell.cutoff_V = 3.0;
  request.cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {4.0, 4.0});
  request.cell.series_resistance_Ohm = 0.0;
  request.power = PowerMission{.legs = {{.power_W = 40.0}}};
  request.options.step_s = 0.1;
  return request;
}

bool Same(const EnduranceResult& a, const EnduranceResult& b) {
  return a.time_s == b.time_s && a.charge_C == b.charge_C && a.ended_by == b.ended_by &&
         a.landing_voltage_V == b.landing_voltage_V && a.energy_J == b.energy_J;
}

TEST(EnduranceRequest, TimeIsCapacityLessReserveOverCurrent) {
  EnduranceRequest request = Simple();
  request.reserve = {0.3, 0.0};
  request.health = {0.6, 0.0};
  request.power_factor = {2.0, 0.0};
  const EnduranceAnswer answer = FindEndurance(request);
  EXPECT_NEAR(answer.estimate.time_s, 3600.0 * 0.6 * 0.7 / 20.0, 1e-6);
  EXPECT_TRUE(answer.flights.empty());
}

TEST(EnduranceRequest, AnEnsembleIsTheSameOnAnyNumberOfThreadsAndOfAnySize) {
  EnduranceRequest request = MamboOfCoarseSteps();
  request.cell.uncertainty =
      Cell::Uncertainty{.parameters = {"r_s"}, .covariance = {{4e-4}}, .degrees_of_freedom = 20.0};
  request.payload_kg = {0.002, 0.001};
  request.health = {0.9, 0.05};
  request.ensemble = 12;
  std::atomic<int> told = 0;
  const EnduranceAnswer many = FindEndurance(request, [&](double) { ++told; });
  ASSERT_EQ(many.flights.size(), 12U);
  EXPECT_EQ(told, 2);  // groups
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  request.ensemble = 5;
  const EnduranceAnswer few = FindEndurance(request);
  for (std::size_t k = 0; k < few.flights.size(); ++k)
    EXPECT_TRUE(Same(few.flights[k], many.flights[k])) << k;
  EXPECT_FALSE(Same(many.flights[0], many.flights[1]));
  EXPECT_TRUE(Same(few.estimate, many.estimate));
  request.seed = 4;
  EXPECT_FALSE(Same(FindEndurance(request).flights[0], few.flights[0]));
}

// Time goes with health: a normal number drawn 2000 times has these quantiles, of which the
// standard error is sqrt(p (1 - p)/n)/density = 2.6 sigma/sqrt(n).
TEST(EnduranceRequest, TheIntervalIsThatOfTheUncertainValue) {
  EnduranceRequest request = Simple();
  request.reserve = {0.0, 0.0};
  request.health = {0.8, 0.02};
  request.ensemble = 2000;
  const EnduranceAnswer answer = FindEndurance(request);
  const auto interval = IntervalOf(answer, EnduranceNumbers()[0]);
  ASSERT_TRUE(interval);
  const double minutes = 0.8 * 6.0;
  const double sigma = 0.02 * 6.0;
  const double allowed = 4.0 * 2.6 * sigma / std::sqrt(2000.0);
  EXPECT_NEAR(interval->first, minutes - 1.95996 * sigma, allowed);
  EXPECT_NEAR(interval->second, minutes + 1.95996 * sigma, allowed);
}

TEST(EnduranceRequest, EachCellDrawnFliesItsOwnFlight) {
  EnduranceRequest request = MamboOfCoarseSteps();
  request.cell.uncertainty =
      Cell::Uncertainty{.parameters = {"r_s"}, .covariance = {{4e-4}}, .degrees_of_freedom = 1e7};
  request.ensemble = 4;
  const EnduranceAnswer answer = FindEndurance(request);
  // Flown alone a flight differs by rounding from one among others.
  constexpr double kRounding = 1e-9;
  const auto cells = DrawCells(request.cell, 4, request.seed).cells;
  for (std::size_t k = 0; k < cells.size(); ++k) {
    EnduranceRequest own = request;
    own.cell = cells[k];
    const double alone_s = FindEndurance(own).estimate.time_s;
    EXPECT_NEAR(alone_s, answer.flights[k].time_s, kRounding * alone_s) << k;
  }
  EXPECT_GT(std::abs(answer.flights[0].time_s - answer.flights[1].time_s), 1e-3);
}

TEST(EnduranceRequest, PayloadColdAndAgeShortenTheFlight) {
  const double minutes = FindEndurance(MamboOfCoarseSteps()).estimate.time_s;
  EnduranceRequest heavy = MamboOfCoarseSteps();
  heavy.payload_kg = {0.005, 0.0};
  const EnduranceAnswer loaded = FindEndurance(heavy);
  EXPECT_LT(loaded.estimate.time_s, 0.95 * minutes);
  EXPECT_NEAR(loaded.flight.thrust_N, (0.063 + 0.005) * 9.81, 1e-12);
  EnduranceRequest worn = MamboOfCoarseSteps();
  worn.resistance_factor = {1.5, 0.0};
  EXPECT_LT(FindEndurance(worn).estimate.time_s, 0.95 * minutes);
}

TEST(EnduranceRequest, CruiseAndWindAreFlownAtTheirSpeeds) {
  EnduranceRequest request = MamboOfCoarseSteps();
  request.vehicle.propeller_diameter_m = 0.066;
  request.vehicle.torque_coefficient_N_m_s2 = 3e-10;
  request.cell.series = 2;
  request.vehicle.mass_kg = 0.08;
  request.reserve = {0.5, 0.0};
  const EnduranceAnswer hover = FindEndurance(request);
  EXPECT_FALSE(hover.speeds);
  EXPECT_EQ(hover.estimate.distance_m, 0.0);
  request.cruise = true;
  const EnduranceAnswer far = FindEndurance(request);
  ASSERT_TRUE(far.speeds);
  EXPECT_EQ(far.flight.airspeed_m_per_s, far.speeds->range.airspeed_m_per_s);
  EXPECT_NEAR(far.estimate.distance_m,
              far.flight.airspeed_m_per_s * far.estimate.time_s,
              1e-9 * far.estimate.distance_m);
  request.cruise_speed = CruiseSpeed::kBestEndurance;
  const EnduranceAnswer longest = FindEndurance(request);
  EXPECT_GT(longest.estimate.time_s, far.estimate.time_s);
  EXPECT_GT(longest.estimate.time_s, hover.estimate.time_s);
  EXPECT_LT(longest.estimate.distance_m, far.estimate.distance_m);
  // In that wind it hovers as long, and stays where it is.
  request.cruise = false;
  request.airspeed_m_per_s = Uncertain{longest.flight.airspeed_m_per_s, 0.0};
  const EnduranceAnswer windy = FindEndurance(request);
  EXPECT_EQ(windy.estimate.time_s, longest.estimate.time_s);
  EXPECT_EQ(windy.estimate.distance_m, 0.0);
  request.airspeed_m_per_s = Uncertain{90.0, 0.0};
  request.vehicle.linear_drag_N_s_per_m = 0.0;
  request.air.flat_plate_area_m2 = 1e-6;
  EXPECT_THROW((void)FindEndurance(request), OptionError);
}

// Of a pack whose resistance decides when a flight ends the least energy per way is not the farthest way.
TEST(EnduranceRequest, NoSpeedCarriesThisBatteryFartherThanTheBestOne) {
  EnduranceRequest request = MamboOfCoarseSteps();
  request.vehicle.propeller_diameter_m = 0.066;
  request.vehicle.torque_coefficient_N_m_s2 = 3e-10;
  request.cell.series = 2;
  request.vehicle.mass_kg = 0.08;
  request.resistance_factor = {3.0, 0.0};
  request.cruise = true;
  const EnduranceAnswer far = FindEndurance(request);
  ASSERT_TRUE(far.speeds);
  const double voltage_V = request.cell.series * request.cell.open_circuit_voltage(0.5);
  const auto ideal = FindBestSpeeds(request.vehicle, voltage_V);
  ASSERT_TRUE(ideal);
  EXPECT_LT(far.flight.airspeed_m_per_s, 0.9 * ideal->range.airspeed_m_per_s);
  request.cruise_speed = CruiseSpeed::kBestEndurance;
  const EnduranceAnswer longest = FindEndurance(request);
  constexpr double kSteps = 1e-3;  // of flights that end with a time step
  for (double v = 0.0; v <= far.speeds->fastest_m_per_s; v += 0.3) {
    request.airspeed_m_per_s = Uncertain{v, 0.0};
    const EnduranceResult flight = FindEndurance(request).estimate;
    EXPECT_LE(flight.distance_m, (1.0 + kSteps) * far.estimate.distance_m) << v;
    EXPECT_LE(flight.time_s, (1.0 + kSteps) * longest.estimate.time_s) << v;
  }
  request.airspeed_m_per_s = Uncertain{1.05 * far.speeds->fastest_m_per_s, 0.0};
  EXPECT_LT(FindEndurance(request).estimate.time_s, 10.0);
}

// A 3DR Solo with gimbal and camera was logged to hover with 230.2 W (tests/reference/cruise_power.py), on 4 cells of 5.2 Ah, whose
// energy at the nominal 3.7 V a cell is 77 Wh. The cell here is one of 32 Ah, resized.
TEST(EnduranceRequest, ASoloHoversAsLongAsItsLoggedPowerAllows) {
  EnduranceRequest request;
  request.vehicle = LoadVehicle("camera-10in");
  request.cell = LoadCell("grepow-32Ah-1");
  request.cell.series = 4;
  request.size_factor = 5.2 / request.cell.capacity_Ah;
  request.reserve = {0.1, 0.0};
  constexpr double kMinutes = 0.9 * 4 * 3.7 * 5.2 / 230.2 * 60.0;
  EXPECT_NEAR(FindEndurance(request).estimate.time_s / 60.0, kMinutes, 0.1 * kMinutes);
}

TEST(EnduranceRequest, StartsAtTheVoltageOfRest) {
  EnduranceRequest request = Simple();
  request.cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  request.cell.series = 2;
  request.initial_voltage_V = 7.5;
  request.reserve = {0.25, 0.0};
  EXPECT_NEAR(FindEndurance(request).estimate.charge_C, 0.5 * 3600.0, 1e-6);
}

TEST(EnduranceRequest, SaysWhatCannotBe) {
  EnduranceRequest request = Simple();
  request.reserve = {1.0, 0.0};
  EXPECT_THROW((void)FindEndurance(request), OptionError);
  request = Simple();
  request.initial_soc = 0.2;
  try {
    (void)FindEndurance(request);
    ADD_FAILURE() << "an empty battery flew";
  } catch (const OptionError& error) {
    EXPECT_STREQ(
        error.what(),
        "the battery starts at a state of charge of 0.2, which is not above the reserve of "
        "0.2: nothing to fly with. Start with more or keep less");
  }
  request = Simple();
  request.health = {0.8, -0.1};
  EXPECT_THROW((void)FindEndurance(request), OptionError);
}

}  // namespace
}  // namespace lipoid
