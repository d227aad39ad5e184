// The residual of (4.61) over a pulse log of the thesis: 2.2 million rows at 10 ms. Rows per second
// of one sweep, of value alone and with its Jacobian, after the norm was checked against the
// prediction; of the whole of stage 3; and of the v_oc(A) of a low-rate log of 4.7 million rows.
//
//   lipoid_bench --benchmark_filter='Sweep|Fit'
#include <benchmark/benchmark.h>

#include <cmath>

#include "identify/stages/open_circuit_voltage_fit.h"
#include "identify/stages/pulse_fit.h"
#include "identify/stages/voltage_sweep.h"
#include "tests/bench/bench_cell.h"

namespace lipoid {
namespace {

using bench::BenchCell;
using bench::BenchLog;
using bench::kNoise_V;

VoltageSweep BenchSweep(const Cell& cell, const Record& record) {
  return {{.alpha_C = cell.diffusion->alpha_C,
           .terms = cell.diffusion->terms,
           .open_circuit_voltage = cell.open_circuit_voltage},
          {{.record = &record}}};
}

// Arguments: terms, branches, whether with the Jacobian.
void Sweep(benchmark::State& state) {
  const Cell cell = BenchCell(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  const Record record = BenchLog(cell, 12, 3.6, 30.0, 1800.0);
  const VoltageSweep sweep = BenchSweep(cell, record);
  SweepParameters p{.beta_per_sqrt_s = 0.1924,
                    .series_resistance_Ohm = 0.1314,
                    .resistance_Ohm = {},
                    .time_constant_s = {}};
  for (const auto& branch : cell.branches) {
    p.resistance_Ohm.push_back(branch.resistance_Ohm.resistance_Ohm[0]);
    p.time_constant_s.push_back(branch.time_constant_s);
  }
  const bool jacobian = state.range(2) != 0;
  const auto norm = [&] {
    const Eigen::MatrixXd factor = sweep.Factor(p, jacobian);
    return factor.rightCols(1).norm();
  };
  const double expected =
      sweep.Errors(p).metrics.rmse * std::sqrt(static_cast<double>(record.size()));
  if (!(std::abs(norm() - expected) < 1e-9 * expected)) {
    state.SkipWithError("the norm is not that of the prediction");
    return;
  }
  for (auto _ : state) benchmark::DoNotOptimize(norm());
  state.SetItemsProcessed(static_cast<std::int64_t>(record.size()) * state.iterations());
}
BENCHMARK(Sweep)
    ->ArgNames({"terms", "branches", "jacobian"})
    ->Args({10, 1, 0})
    ->Args({10, 1, 1})
    ->Args({10, 0, 1})
    ->Args({10, 3, 1})
    ->Args({40, 1, 1})
    ->Unit(benchmark::kMillisecond);

void FitPulseLog(benchmark::State& state) {
  const Cell cell = BenchCell(10, 1);
  const Record record = BenchLog(cell, 12, 3.6, 30.0, 1800.0);
  const VoltageSweep sweep = BenchSweep(cell, record);
  PulseFitResult fit;
  for (auto _ : state) fit = FitPulses(sweep, {.data = FindStartValues({&record})});
  if (!(std::abs(fit.errors.rmse - kNoise_V) < 0.01 * kNoise_V))
    state.SkipWithError("the noise was not reached");
  state.counters["sweeps"] = fit.evaluations;
  state.SetItemsProcessed(static_cast<std::int64_t>(record.size()) * state.iterations());
}
BENCHMARK(FitPulseLog)->Unit(benchmark::kMillisecond);

// Argument: the method, in the order of OcvMethod.
void FitLowRateLog(benchmark::State& state) {
  const Cell cell = BenchCell(10, 0);
  const Record record = BenchLog(cell, 1, 0.0288, 47000.0, 0.0);
  OcvFitResult fit;
  for (auto _ : state) {
    fit = FitOpenCircuitVoltage(
        record, cell.diffusion->alpha_C, 1.0, {.method = static_cast<OcvMethod>(state.range(0))});
  }
  if (!(fit.errors.rmse < 0.02)) state.SkipWithError("the curve is not that of the log");
  state.SetItemsProcessed(static_cast<std::int64_t>(record.size()) * state.iterations());
}
BENCHMARK(FitLowRateLog)->ArgName("method")->DenseRange(0, 3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lipoid
