#include "identify/health/flight_samples.h"

#include <gtest/gtest.h>

#include "tests/support/synthetic_flight.h"

namespace lipoid::test {
namespace {

Log Recorded(const FlightRecorder& recorder) {
  FlightPlan plan;
  plan.charge_share = 0.3;
  return FlyAndLog(WithTypicalTemperature(NewFlightCell()), 1, plan, recorder, "f").log;
}

// Sampled at the same instant there is no lag and nothing to average.
TEST(FlightSamples, OfSimultaneousRowsAreTheRows) {
  FlightRecorder recorder;
  recorder.lag_s = 0.0;
  recorder.voltage_noise_V = 0.0;
  recorder.voltage_step_V = 1e-4;
  const FlightSamples samples = SampleFlight(Recorded(recorder));
  EXPECT_EQ(samples.window_s, 0.0);
  EXPECT_NEAR(samples.lag_s, 0.0, 0.03);  // half a step of the grid
  EXPECT_GT(samples.coherence, 0.99);
  EXPECT_EQ(samples.windows.size(), samples.record.size());
  // r_s of 4 milliohm and what diffusion does at once.
  EXPECT_NEAR(samples.edge_resistance_Ohm, 0.0042, 0.0006);
}

TEST(FlightSamples, FindTheLag) {
  FlightRecorder recorder;
  recorder.lag_s = 0.6;
  recorder.voltage_noise_V = 0.0;
  recorder.voltage_step_V = 1e-4;
  const FlightSamples samples = SampleFlight(Recorded(recorder));
  EXPECT_NEAR(samples.lag_s, 0.6, 0.05);
}

// A voltage that is repeated for 0.8 s counts once.
TEST(FlightSamples, OfAStaircaseAreItsSteps) {
  FlightRecorder recorder = LikeArduPilot();
  recorder.voltage_step_V = 1e-4;
  const Log log = Recorded(recorder);
  const FlightSamples samples = SampleFlight(log);
  EXPECT_NEAR(samples.voltage_update_s, 0.8, 0.01);
  const double length_s = log.record.time_s.back() - log.record.time_s.front();
  EXPECT_NEAR(static_cast<double>(samples.fresh.size()), length_s / 0.8, 0.03 * length_s / 0.8);
}

TEST(FlightSamples, LeaveOutTheUnplugging) {
  Log log = Recorded({});
  log.record.time_s.push_back(log.record.time_s.back() + 0.2);
  log.record.current_A.push_back(-0.4);
  log.record.voltage_V.push_back(0.9 * log.record.voltage_V.back());
  const std::size_t rows = log.record.size();
  const FlightSamples samples = SampleFlight(log);
  EXPECT_EQ(samples.dropped_rows, 1U);
  EXPECT_EQ(samples.record.size(), rows - 1);
}

// Averages of a straight line are the line at the mean of the times, and its slope in the lag is
// minus its slope.
TEST(FlightSamples, WindowsKeepAStraightLine) {
  const FlightSamples samples = SampleFlight(Recorded({}));
  const auto n = static_cast<Eigen::Index>(samples.record.size());
  Eigen::VectorXd line(n);
  for (Eigen::Index k = 0; k < n; ++k)
    line[k] = 3.0 - 0.01 * samples.record.time_s[static_cast<std::size_t>(k)];
  constexpr double kLag_s = 0.33;
  const Eigen::VectorXd in = samples.InWindows(line, kLag_s);
  const Eigen::VectorXd slope = samples.LagSlope(line, kLag_s);
  for (std::size_t w = 5; w + 5 < samples.windows.size(); ++w) {
    EXPECT_NEAR(in[static_cast<Eigen::Index>(w)], 3.0 - 0.01 * (samples.time_s[w] - kLag_s), 1e-9);
    EXPECT_NEAR(slope[static_cast<Eigen::Index>(w)], 0.01, 1e-9);
  }
}

}  // namespace
}  // namespace lipoid::test
