// What the machine can do, to say how far from it a stage is: bytes read per second and floating
// point operations per second, by one thread and by all.
//
//   lipoid_bench --benchmark_filter=Limit
#include <benchmark/benchmark.h>

#include <vector>

namespace lipoid {
namespace {

// Reads 256 MB: larger than the caches of a core.
void LimitReadMemory(benchmark::State& state) {
  static const std::vector<double> values(std::size_t{1} << 25, 1.0);
  for (auto _ : state) {
    double sums[16] = {};
    for (std::size_t k = 0; k < values.size(); k += 16) {
      for (std::size_t j = 0; j < 16; ++j) sums[j] += values[k + j];
    }
    benchmark::DoNotOptimize(sums);
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(values.size() * sizeof(double)) *
                          state.iterations());
}
BENCHMARK(LimitReadMemory)->UseRealTime()->Unit(benchmark::kMillisecond);
BENCHMARK(LimitReadMemory)->ThreadPerCpu()->UseRealTime()->Unit(benchmark::kMillisecond);

// Chains of multiplications and additions, not fused (lipoid is built without contraction, so that
// every machine computes the same bits), enough of them to fill the registers and the pipeline.
constexpr int kChains = 96;
constexpr int kSteps = 4096;

inline __attribute__((always_inline)) void Steps(double* x, double a, double b) {
  for (int step = 0; step < kSteps; ++step) {
    for (int k = 0; k < kChains; ++k) x[k] = a * x[k] + b;
  }
}

void StepsPortable(double* x, double a, double b) { Steps(x, a, b); }

using StepsFunction = void (*)(double*, double, double);

#if defined(__x86_64__)
__attribute__((target("avx2"))) void StepsAvx2(double* x, double a, double b) { Steps(x, a, b); }
#if defined(__clang__)  // knows no width by function
#define LIPOID_WIDEST "avx512f"
#else
#define LIPOID_WIDEST "avx512f,prefer-vector-width=512"
#endif
__attribute__((target(LIPOID_WIDEST))) void StepsAvx512(double* x, double a, double b) {
  Steps(x, a, b);
}

StepsFunction BestSteps() {
  if (__builtin_cpu_supports("avx512f")) return &StepsAvx512;
  if (__builtin_cpu_supports("avx2")) return &StepsAvx2;
  return &StepsPortable;
}
#else
StepsFunction BestSteps() { return &StepsPortable; }
#endif

void LimitMultiplyAdd(benchmark::State& state) {
  const StepsFunction steps = BestSteps();
  double x[kChains] = {};
  for (auto _ : state) {
    steps(x, 0.999, 1e-3);
    benchmark::DoNotOptimize(x);
  }
  state.counters["flops_per_s"] =
      benchmark::Counter(2.0 * kChains * kSteps, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(LimitMultiplyAdd)->UseRealTime();
BENCHMARK(LimitMultiplyAdd)->ThreadPerCpu()->UseRealTime();

}  // namespace
}  // namespace lipoid
