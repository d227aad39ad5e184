// Endurance flights of an ensemble in steps of 5 ms, one after the other and eight at a time; items
// are steps of the cell. Goal: 1,000 flights of the Mambo within 10 s on two cores.
//
//   lipoid_bench --benchmark_filter=Endurance
#include <benchmark/benchmark.h>

#include "model/battery/cell_file.h"
#include "model/flight/endurance.h"
#include "model/flight/endurance_request.h"
#include "model/vehicle/level_flight.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

constexpr double kStep_s = 0.005;

std::vector<EnduranceSetup> Hovers() {
  const Vehicle vehicle = LoadVehicle("mambo-physical");
  const LevelFlight hover = Cruise(vehicle, 0.0);
  EnduranceSetup setup;
  setup.cell = LoadCell("gifi-600mAh-1");
  setup.options.step_s = kStep_s;
  setup.mission.legs = {{.drive_W = BatteryPower(vehicle, hover, vehicle.nominal_voltage_V),
                         .least_V = hover.battery_V}};
  std::vector<EnduranceSetup> setups(kMissionsAtOnce, setup);
  for (std::size_t k = 0; k < setups.size(); ++k)
    setups[k].mission.legs[0].drive_W *= 1.0 + 0.01 * static_cast<double>(k);
  return setups;
}

void CountSteps(benchmark::State& state, const std::vector<EnduranceResult>& flights) {
  double steps = 0.0;
  for (const EnduranceResult& flight : flights) {
    if (flight.ended_by != MissionEnd::kCutOff) state.SkipWithError("not the end expected");
    steps += flight.time_s / kStep_s;
  }
  state.SetItemsProcessed(state.iterations() * static_cast<std::int64_t>(steps));
}

void EnduranceOneAfterTheOther(benchmark::State& state) {
  const auto setups = Hovers();
  std::vector<EnduranceResult> flights(setups.size());
  for (auto _ : state) {
    for (std::size_t k = 0; k < setups.size(); ++k) flights[k] = FlyMission(setups[k]);
  }
  CountSteps(state, flights);
}
BENCHMARK(EnduranceOneAfterTheOther)->Unit(benchmark::kMillisecond);

void EnduranceSideBySide(benchmark::State& state) {
  const auto setups = Hovers();
  std::vector<EnduranceResult> flights;
  for (auto _ : state) flights = FlyMissions(setups);
  CountSteps(state, flights);
}
BENCHMARK(EnduranceSideBySide)->Unit(benchmark::kMillisecond);

// The whole answer, on all cores.
void EnduranceEnsembleOf1000(benchmark::State& state) {
  EnduranceRequest request;
  request.vehicle = LoadVehicle("mambo-physical");
  request.cell = LoadCell("gifi-600mAh-1");
  request.power_factor = {1.0, 0.02};
  request.reserve = {0.0, 0.0};
  request.options.step_s = kStep_s;
  request.ensemble = 1000;
  EnduranceAnswer answer;
  for (auto _ : state) answer = FindEndurance(request);
  CountSteps(state, answer.flights);
}
BENCHMARK(EnduranceEnsembleOf1000)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace lipoid
