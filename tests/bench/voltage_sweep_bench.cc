// The residual of (4.61) over a pulse log of the thesis: 2.2 million rows at 10 ms. Rows per second
// of one sweep, of value alone and with its Jacobian, after the norm was checked against the
// prediction; of the whole of stage 3; and of the v_oc(A) of a low-rate log of 4.7 million rows.
//
//   lipoid_bench --benchmark_filter='Sweep|Fit'
#include <benchmark/benchmark.h>

#include <cmath>
#include <random>

#include "identify/stages/open_circuit_voltage_fit.h"
#include "identify/stages/pulse_fit.h"
#include "identify/stages/voltage_sweep.h"
#include "model/battery/prediction.h"

namespace lipoid {
namespace {

constexpr double kNoise_V = 2e-4;

Cell BenchCell(int terms, int branches) {
  Cell cell;
  cell.capacity_Ah = 0.376;
  cell.diffusion = Cell::Diffusion{.alpha_C = 1353.6, .beta_per_sqrt_s = 0.1924, .terms = terms};
  cell.series_resistance_Ohm = Resistance<double>(0.1314);
  for (int j = 0; j < branches; ++j) {
    cell.branches.push_back({.resistance_Ohm = Resistance<double>(0.03),
                             .time_constant_s = 45.0 * std::pow(0.1, j),
                             .capacitance_F = {}});
  }
  std::vector<double> soc;
  std::vector<double> voltage_V;
  for (int k = 0; k <= 200; ++k) {
    const double a = -0.05 + 1.05 * k / 200;
    soc.push_back(a);
    voltage_V.push_back(3.7 + 0.4 * a - 0.6 * std::exp(-30.0 * (a + 0.05)));
  }
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
  return cell;
}

// `count` rounds of `load_s` at current_A and `rest_s` of rest, with 0.2 mV of noise.
Record BenchLog(const Cell& cell, int count, double current_A, double load_s, double rest_s) {
  constexpr double kSampling_s = 0.01;
  Record record;
  const auto round = static_cast<std::size_t>((load_s + rest_s) / kSampling_s);
  const std::size_t rows = static_cast<std::size_t>(count) * round + 1;
  record.time_s.resize(rows);
  record.current_A.resize(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    record.time_s[k] = static_cast<double>(k) / 100.0;
    const bool load = k > 0 && static_cast<double>((k - 1) % round) * kSampling_s < load_s;
    record.current_A[k] = load ? current_A : 0.0;
  }
  record.voltage_V = Predict(cell, record.time_s, record.current_A).voltage_V;
  std::mt19937 engine(1);
  std::normal_distribution<double> normal;
  for (double& v : record.voltage_V) v += kNoise_V * normal(engine);
  return record;
}

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
      SweepErrors(sweep, p).rmse * std::sqrt(static_cast<double>(record.size()));
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
  if (!(fit.rmse_V < 0.02)) state.SkipWithError("the curve is not that of the log");
  state.SetItemsProcessed(static_cast<std::int64_t>(record.size()) * state.iterations());
}
BENCHMARK(FitLowRateLog)->ArgName("method")->DenseRange(0, 3)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace lipoid
