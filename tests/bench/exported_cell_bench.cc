// A step of a cell and its voltage after it: lipoid's own, and the exported C compiled by cc -O2, in
// double and in float. The answers are compared first.
//
//   lipoid_bench --benchmark_filter=CellStep
#include <benchmark/benchmark.h>
#include <dlfcn.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "model/battery/cell_file.h"
#include "model/export/c_code.h"

namespace lipoid {
namespace {

constexpr const char* kCell = "gifi-600mAh-1";
constexpr double kStep_s = 0.005;
constexpr int kSteps = 20000;

// 100 s of a current that changes at every step.
double CurrentAt(int k) { return 2.0 + 0.1 * (k % 16); }

double RunModel(const CellModel<double>& model) {
  auto state = model.Relaxed(1.0);
  const auto step = model.MakeStep(kStep_s);
  double sum_V = 0.0;
  for (int k = 0; k < kSteps; ++k) {
    model.Advance(state, CurrentAt(k), step);
    sum_V += model.Voltage(state, CurrentAt(k));
  }
  return sum_V / kSteps;
}

void CellStep(benchmark::State& state) {
  const CellModel<double> model(LoadCell(kCell).Parameters());
  for (auto _ : state) benchmark::DoNotOptimize(RunModel(model));
  state.SetItemsProcessed(kSteps * state.iterations());
}
BENCHMARK(CellStep);

constexpr const char* kLoop = R"(
#include "cell.h"
double run(int steps) {
  int k;
  double sum_V = 0.0;
  bench_state state;
  bench_step step;
  bench_start(&state, 1);
  bench_make_step(&step, (bench_real)0.005);
  for (k = 0; k < steps; ++k) {
    const bench_real current_A = (bench_real)2 + (bench_real)(k % 16) * (bench_real)0.1;
    bench_advance(&state, &step, current_A);
    sum_V += (double)bench_voltage_V(&state, current_A);
  }
  return sum_V / steps;
}
)";

void Exported(benchmark::State& state, const char* version) {
  ExportRequest request;
  request.cell = LoadCell(kCell);
  request.source = kCell;
  request.mission = {.name = "none",
                     .time_s = {0.0},
                     .current_A = {0.0},
                     .hold = Hold::kBackward,
                     .initial_soc = 1.0};
  request.target_version = version;
  request.name = "bench";
  request.stem = "cell";
  const auto exported = ExportC(request);
  const auto folder = std::filesystem::temp_directory_path() /
                      ("lipoid_bench_" + std::to_string(::getpid()) + "_" + version);
  std::filesystem::create_directories(folder);
  std::ofstream(folder / "cell.h") << exported.files[0].content;
  std::ofstream(folder / "cell.c") << exported.files[1].content;
  std::ofstream(folder / "loop.c") << kLoop;
  const std::string command =
      "cd '" + folder.string() + "' && cc -std=c99 -O2 -shared -fPIC cell.c loop.c -lm -o cell.so";
  const bool compiled = std::system(command.c_str()) == 0;
  void* const library = compiled ? dlopen((folder / "cell.so").c_str(), RTLD_NOW) : nullptr;
  std::filesystem::remove_all(folder);
  if (library == nullptr) {
    state.SkipWithError("cc did not compile the exported cell");
    return;
  }
  using Run = double (*)(int);
  const Run run = reinterpret_cast<Run>(dlsym(library, "run"));
  const double expected_V = RunModel(CellModel<double>(request.cell.Parameters()));
  constexpr double kFoldedBranch_V = 1e-4;  // 2.4e-5 Ohm at the jumps of the current
  if (!(std::abs(run(kSteps) - expected_V) < kFoldedBranch_V)) {
    state.SkipWithError("the exported cell has another voltage");
  } else {
    for (auto _ : state) benchmark::DoNotOptimize(run(kSteps));
    state.SetItemsProcessed(kSteps * state.iterations());
  }
  dlclose(library);
}
BENCHMARK_CAPTURE(Exported, CellStepInDouble, "double");
BENCHMARK_CAPTURE(Exported, CellStepInFloat, "float");

}  // namespace
}  // namespace lipoid
