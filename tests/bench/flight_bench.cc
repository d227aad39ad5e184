// Closed-loop control steps of 5 ms per second of one core. Goals: 500,000 on the coupled cell with
// perfect state, 100,000 with sensors and estimator. And one evaluation of the cost of a gain
// design.
//
//   lipoid_bench --benchmark_filter=Flight
#include <benchmark/benchmark.h>

#include "identify/gains/gain_design.h"
#include "model/battery/cell_file.h"
#include "model/flight/maneuvers/maneuvers.h"
#include "model/flight/simulator.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

FlightSetup Setup() {
  FlightSetup setup;
  setup.vehicle = LoadVehicle("mambo-coupled");
  setup.cell = LoadCell("gifi-600mAh-1");
  setup.gains = LoadGains("aware");
  return setup;
}

// Counts only what the loop itself needed; a flight that does not end as it should is an error.
void Run(benchmark::State& state, const FlightSetup& setup, const FlightPlan& plan) {
  std::size_t steps = 0;
  for (auto _ : state) {
    const FlightResult flight = Fly(setup, plan);
    if (flight.outcome != Outcome::kCompleted) state.SkipWithError(flight.reason.c_str());
    steps += flight.steps;
    state.SetIterationTime(flight.wall_s);
  }
  state.SetItemsProcessed(static_cast<std::int64_t>(steps));
}

void FlightAltitudeSteps(benchmark::State& state) { Run(state, Setup(), AltitudeSteps().plan({})); }
BENCHMARK(FlightAltitudeSteps)->UseManualTime()->Unit(benchmark::kMillisecond);

void FlightSquare(benchmark::State& state) { Run(state, Setup(), Square().plan({})); }
BENCHMARK(FlightSquare)->UseManualTime()->Unit(benchmark::kMillisecond);

void FlightEstimated(benchmark::State& state) {
  FlightSetup setup = Setup();
  setup.estimate = true;
  Run(state, setup, AltitudeSteps().plan({}));
}
BENCHMARK(FlightEstimated)->UseManualTime()->Unit(benchmark::kMillisecond);

void FlightEstimatedInGusts(benchmark::State& state) {
  FlightSetup setup = Setup();
  setup.vehicle = LoadVehicle("mambo-physical");  // mambo-coupled has too little to spare
  setup.estimate = true;
  setup.wind.gusts_m_per_s = 2.0;
  Run(state, setup, AltitudeSteps().plan({}));
}
BENCHMARK(FlightEstimatedInGusts)->UseManualTime()->Unit(benchmark::kMillisecond);

// (6.3): 21 voltages, 5 s.
void FlightGainDesignCost(benchmark::State& state) {
  GainDesign design;
  design.vehicle = LoadVehicle("mambo-thesis");
  for (int k = 0; k <= 20; ++k) design.xi.push_back({0.8 + 0.01 * k, 1.0});
  const GainProblem problem(design);
  const Eigen::VectorXd x = problem.Point(LoadGains("aware").altitude);
  for (auto _ : state) benchmark::DoNotOptimize(problem.Cost(x));
  state.SetItemsProcessed(state.iterations() * 21 * 1000);
}
BENCHMARK(FlightGainDesignCost)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lipoid
