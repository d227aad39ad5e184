// One control step of what flies beside the plant: wind, sensors, estimator. The closed loop with
// sensors and estimator has 10 us per step of 5 ms; these two may take 4 of them.
//
//   lipoid_bench --benchmark_filter=Sensors
#include <benchmark/benchmark.h>

#include <cmath>
#include <vector>

#include "model/control/estimator.h"
#include "model/vehicle/sensors.h"
#include "model/vehicle/wind.h"

namespace lipoid {
namespace {

SensedMotion Swaying(int step) {
  const double t_s = step * kControlStep_s;
  SensedMotion motion;
  motion.position_m = {0.0, 0.0, -1.5};
  motion.angles_rad = {0.05 * std::sin(t_s), 0.05 * std::cos(t_s), 0.1};
  motion.body_rates_rad_per_s = {0.05 * std::cos(t_s), -0.05 * std::sin(t_s), 0.0};
  motion.specific_force_m_per_s2 = {0.0, 0.0, -kGravity_m_per_s2};
  motion.battery_V = 3.9;
  return motion;
}

// The motions are made outside of the time.
std::vector<SensedMotion> Motions() {
  std::vector<SensedMotion> motions;
  for (int k = 0; k < 4096; ++k) motions.push_back(Swaying(k));
  return motions;
}

void SensorsRead(benchmark::State& state) {
  const auto motions = Motions();
  Sensors sensors({}, 1);
  std::size_t k = 0;
  for (auto _ : state) benchmark::DoNotOptimize(sensors.Read(motions[k++ % motions.size()]));
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(SensorsRead);

void SensorsAndEstimator(benchmark::State& state) {
  const auto motions = Motions();
  Sensors sensors({}, 1);
  Estimator estimator({});
  std::vector<SensorReadings> at_rest;
  SensedMotion rest = Swaying(0);
  rest.angles_rad = {};
  rest.body_rates_rad_per_s = {};
  for (int k = 0; k < 400; ++k) at_rest.push_back(sensors.Read(rest));
  estimator.Reset({.position_m = rest.position_m}, at_rest);
  MeasuredState measured;
  std::size_t k = 0;
  for (auto _ : state) {
    measured = estimator.Step(sensors.Read(motions[k++ % motions.size()]));
    benchmark::DoNotOptimize(measured);
  }
  // The right answer? 0.3 m is six times the noise of the sonar, 0.1 rad twice the sway.
  if (!(std::abs(measured.position_m[2] + 1.5) < 0.3) ||
      !(std::abs(measured.angles_rad[0]) < 0.1)) {
    state.SkipWithError("the estimate is not near the truth");
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(SensorsAndEstimator);

void SensorsWind(benchmark::State& state) {
  WindOptions options;
  options.wind_x_m_per_s = 3.0;
  options.gusts_m_per_s = 5.0;
  Wind wind(options, 1);
  double altitude_m = 5.0;
  Triple<double> now{};
  for (auto _ : state) {
    altitude_m = 10.0 + 0.5 * now[2];  // changes each step, as in flight
    now = wind.Step(altitude_m, 3.0);
    benchmark::DoNotOptimize(now);
  }
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(SensorsWind);

}  // namespace
}  // namespace lipoid
