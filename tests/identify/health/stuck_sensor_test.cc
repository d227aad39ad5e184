#include "identify/health/stuck_sensor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/synthetic_flight.h"

namespace lipoid::test {
namespace {

// One cell of a pack of four, whose voltage is measured.
Log Flown(FlightRecorder recorder) {
  recorder.voltage_step_V /= 4.0;
  recorder.voltage_noise_V /= 4.0;
  FlightPlan plan;
  plan.charge_share = 0.4;
  return FlyAndLog(WithTypicalTemperature(NewFlightCell()), 1, plan, recorder, "f").log;
}

// Rows of `column` from one time to another show what the first of them shows.
void Stick(const Column& time_s, Column& column, double from_s, double to_s) {
  const auto row = [&](double at_s) {
    return static_cast<std::size_t>(std::lower_bound(time_s.begin(), time_s.end(), at_s) -
                                    time_s.begin());
  };
  for (std::size_t k = row(from_s); k < row(to_s); ++k) column[k] = column[row(from_s)];
}

class StuckSensors : public ::testing::TestWithParam<FlightRecorder> {};

TEST_P(StuckSensors, AreNotFoundWhereNoneIsStuck) {
  const FlightSamples flight = SampleFlight(Flown(GetParam()));
  EXPECT_EQ(flight.stuck_voltage_s, 0.0);
  EXPECT_EQ(flight.doubt, "");
}

TEST_P(StuckSensors, OfTheVoltageAreLeftOut) {
  Log log = Flown(GetParam());
  Stick(log.record.time_s, log.record.voltage_V, 60.0, 130.0);
  const FlightSamples flight = SampleFlight(log);
  EXPECT_NEAR(flight.stuck_voltage_s, 70.0, 2.0);  // the value may have stood before
  for (const std::size_t row : flight.fresh) {
    const double at_s = flight.record.time_s[row];
    EXPECT_TRUE(at_s < 61.0 || at_s > 129.0) << at_s;
  }
  EXPECT_EQ(flight.doubt, "");
}

// The start of a flight is where a pack is fullest: rows in which the sensor showed less made it start at 77 %, known to 2 %.
TEST_P(StuckSensors, NoRowOfAVoltageAtTheEndOfItsRangeIsLeft) {
  Log log = Flown(GetParam());
  std::vector<double> rising = log.record.voltage_V.ToVector();
  std::sort(rising.begin(), rising.end());
  const double end_V = rising[rising.size() * 9 / 10];
  for (double& voltage_V : log.record.voltage_V) voltage_V = std::min(voltage_V, end_V);
  const FlightSamples flight = SampleFlight(log);
  EXPECT_GT(flight.stuck_voltage_s, 2.0);
  EXPECT_GT(flight.fresh.size(), 100U);
  for (const std::size_t row : flight.fresh) EXPECT_LT(flight.record.voltage_V[row], end_V) << row;
}

TEST_P(StuckSensors, OfTheCurrentAreDoubted) {
  Log log = Flown(GetParam());
  Stick(log.record.time_s, log.record.current_A, 60.0, 130.0);
  EXPECT_NE(SampleFlight(log).doubt.find("the sensor was stuck"), std::string::npos);
}

TEST_P(StuckSensors, AtTheEndOfTheirRangeAreDoubted) {
  Log log = Flown(GetParam());
  for (double& current_A : log.record.current_A) current_A = std::min(current_A, 33.0);
  EXPECT_NE(SampleFlight(log).doubt.find("shows 33 A, and never more"), std::string::npos);
}

INSTANTIATE_TEST_SUITE_P(Recorders, StuckSensors, ::testing::Values(LikePx4(), LikeArduPilot()));

// After a calm flight the electronics draw one current, to the last digit that the sensor shows, and the cell recovers
// by more from one window to the next than it moved in the air.
TEST(StuckSensor, IsNoneOfACellThatRecoversAfterTheLanding) {
  FlightRecorder recorder = LikePx4();
  recorder.row_s = 0.1;
  recorder.voltage_update_s = 0.1;
  recorder.lag_s = 0.0;
  recorder.voltage_noise_V = 0.00075;
  recorder.voltage_step_V = 0.00025;
  FlightPlan plan;
  plan.charge_share = 0.4;
  plan.unrest = 0.1;
  plan.rest_after_s = 15.0;
  Log log = FlyAndLog(WithTypicalTemperature(NewFlightCell()), 1, plan, recorder, "f").log;
  const double landed_s = log.record.time_s.back() - plan.rest_after_s;
  for (std::size_t k = 0; k < log.record.size(); ++k) {
    const double after_s = log.record.time_s[k] - landed_s;
    if (after_s > 0.0) log.record.voltage_V[k] += 0.1 * (1.0 - std::exp(-after_s / 4.0));
  }
  EXPECT_EQ(SampleFlight(log).doubt, "");
}

// A hover in still air on a coarse voltage shows one value for a long time, and nothing is stuck.
TEST(StuckSensor, IsNoneOfACoarseVoltageInStillAir) {
  FlightRecorder recorder;
  recorder.voltage_step_V = 0.1;
  recorder.voltage_noise_V = 0.0;
  FlightPlan plan;
  plan.unrest = 0.05;
  const Log log = FlyAndLog(WithTypicalTemperature(NewFlightCell()), 1, plan, recorder, "f").log;
  const FlightSamples flight = SampleFlight(log);
  EXPECT_EQ(flight.stuck_voltage_s, 0.0);
  EXPECT_EQ(flight.doubt, "");
}

}  // namespace
}  // namespace lipoid::test
