// One frame of ArduPilot's JSON interface without the network: the datagram read, a step of the
// plant on its cell, the answer written. Goal: 100 times real time at 400 frames a second, 25 us.
//
//   lipoid_bench --benchmark_filter=Live
#include <benchmark/benchmark.h>

#include "model/battery/cell_file.h"
#include "model/flight/ardupilot_json.h"
#include "model/vehicle/vehicle_file.h"

namespace lipoid {
namespace {

void LiveFrame(benchmark::State& state) {
  const auto plant = MakeLivePlant(
      {.vehicle = ForArduCopter(LoadVehicle("mambo-coupled")), .cell = LoadCell("gifi-600mAh-1")});
  ArduPilotPhysics physics(*plant);
  // 400 Hz, pulse widths of 1500 us: on the ground, where the feet are computed too.
  std::string frame("\x1a\x48\x90\x01\0\0\0\0", 8);
  for (int k = 0; k < 16; ++k) frame += std::string("\xdc\x05", 2);
  std::uint32_t count = 0;
  for (auto _ : state) {
    for (std::size_t k = 0; k < 4; ++k)
      frame[4 + k] = static_cast<char>((count >> (8 * k)) & 0xffU);
    if (++count == 20'000) count = 0;  // before the battery is empty: the autopilot starts anew
    const auto answer = physics.Answer(frame);
    if (!answer) state.SkipWithError("no answer");
    benchmark::DoNotOptimize(answer->data());
  }
  if (physics.counts().malformed > 0) state.SkipWithError("malformed frames");
  state.SetItemsProcessed(state.iterations());
}
BENCHMARK(LiveFrame);

}  // namespace
}  // namespace lipoid
