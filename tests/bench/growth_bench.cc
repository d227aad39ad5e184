// How cost grows with rows, branches and terms: one sweep of (4.61) with its Jacobian, the whole
// fit of the pulses, and a prediction that streams its rows and keeps none.
//
//   lipoid_bench --benchmark_filter=Growth --growth-rows=1e8
#include <benchmark/benchmark.h>
#include <unistd.h>

#include <memory>
#include <random>

#include "identify/stages/pulse_fit.h"
#include "identify/stages/start_values.h"
#include "identify/stages/voltage_sweep.h"
#include "model/battery/record_stepper.h"
#include "tests/bench/bench_cell.h"
#include "tests/bench/bench_options.h"

namespace lipoid::bench {
namespace {

constexpr int kTerms = 10;
constexpr int kBranches = 1;
constexpr std::size_t kSomeRows = 1000000;  // where branches and terms grow

double AvailableBytes() {
  return static_cast<double>(sysconf(_SC_AVPHYS_PAGES)) *
         static_cast<double>(sysconf(_SC_PAGESIZE));
}

// The log of the benchmark before, where it had as many rows.
const Record& LogOfRows(std::size_t rows) {
  static std::unique_ptr<Record> log;
  if (log == nullptr || log->size() != rows) {
    log.reset();
    log = std::make_unique<Record>(BenchLogOfRows(BenchCell(kTerms, kBranches), rows));
  }
  return *log;
}

SweepParameters TrueParameters(const Cell& cell) {
  SweepParameters p{.beta_per_sqrt_s = cell.diffusion->beta_per_sqrt_s,
                    .series_resistance_Ohm = cell.series_resistance_Ohm(1.0),
                    .resistance_Ohm = {},
                    .time_constant_s = {}};
  for (const auto& branch : cell.branches) {
    p.resistance_Ohm.push_back(branch.resistance_Ohm(1.0));
    p.time_constant_s.push_back(branch.time_constant_s);
  }
  return p;
}

VoltageSweep SweepOver(const Cell& cell, const Record& record) {
  return {{.alpha_C = cell.diffusion->alpha_C,
           .terms = cell.diffusion->terms,
           .open_circuit_voltage = cell.open_circuit_voltage},
          {{.record = &record}}};
}

// The norm of the residual, row by row by the model itself.
double PlainNorm(const Cell& cell, const Record& record) {
  const CellModel<double> model(cell.Parameters());
  RecordStepper<double> stepper(model, record.hold, model.Relaxed(1.0));
  double squares = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    stepper.Row(record.time_s[k], record.current_A[k]);
    const double error = record.voltage_V[k] - stepper.Voltage();
    squares += error * error;
  }
  return std::sqrt(squares);
}

void ReportRows(benchmark::State& state, std::size_t rows) {
  state.counters["rows"] = static_cast<double>(rows);
  state.SetItemsProcessed(static_cast<std::int64_t>(rows) * state.iterations());
}

// Of a log made with one branch and ten terms; what is asked of the sweep may be more.
void GrowSweep(benchmark::State& state, std::size_t rows, int branches, int terms) {
  const Record& record = LogOfRows(rows);
  const Cell cell = BenchCell(terms, branches);
  const VoltageSweep sweep = SweepOver(cell, record);
  const SweepParameters p = TrueParameters(cell);
  const double norm = sweep.Factor(p, true).rightCols(1).norm();
  const double expected = PlainNorm(cell, record);
  if (!(std::abs(norm - expected) < 1e-9 * expected)) {
    state.SkipWithError("the norm is not that of the prediction");
    return;
  }
  for (auto _ : state) benchmark::DoNotOptimize(sweep.Factor(p, true));
  ReportRows(state, rows);
}

// From the record: start values, all that is prepared once, the search, the answer's errors.
void GrowFit(benchmark::State& state, std::size_t rows) {
  const Record& record = LogOfRows(rows);
  const Cell cell = BenchCell(kTerms, kBranches);
  PulseFitResult fit;
  for (auto _ : state) {
    const VoltageSweep sweep = SweepOver(cell, record);
    fit = FitPulses(sweep, {.data = FindStartValues({&record})});
  }
  if (!(std::abs(fit.errors.rmse - kNoise_V) < 0.1 * kNoise_V))
    state.SkipWithError("the noise was not reached");
  state.counters["evaluations"] = fit.evaluations;
  ReportRows(state, rows);
}

// What is prepared once, before any evaluation.
void GrowPreparation(benchmark::State& state, std::size_t rows) {
  const Record& record = LogOfRows(rows);
  const Cell cell = BenchCell(kTerms, kBranches);
  for (auto _ : state) benchmark::DoNotOptimize(SweepOver(cell, record).rows());
  ReportRows(state, rows);
}

// Rows come, are compared with the model and are forgotten: memory does not grow.
void GrowStream(benchmark::State& state, std::size_t rows) {
  const Cell cell = BenchCell(kTerms, kBranches);
  const CellModel<double> model(cell.Parameters());
  constexpr std::size_t kRound = 180000;
  constexpr std::size_t kLoad = 3000;
  const double current_A = 0.5 * cell.alpha_C() / (static_cast<double>(rows) * kSampling_s);
  double last_V = 0.0;
  for (auto _ : state) {
    RecordStepper<double> stepper(model, Hold::kBackward, model.Relaxed(1.0));
    ErrorAccumulator errors;
    for (std::size_t k = 0; k < rows; ++k) {
      stepper.Row(static_cast<double>(k) / 100.0, k % kRound < kLoad ? current_A : 0.0);
      errors.Add(3.7, stepper.Voltage());
    }
    last_V = stepper.Voltage();
    benchmark::DoNotOptimize(errors.Result().rmse);
  }
  if (!(last_V > 3.0 && last_V < 4.5)) state.SkipWithError("the voltage left the curve");
  ReportRows(state, rows);
}

template <class Body>
void Register(const std::string& name, std::size_t rows, Body&& body) {
  auto* made =
      benchmark::RegisterBenchmark(name.c_str(), [body](benchmark::State& state) { body(state); });
  made->Unit(benchmark::kMillisecond)->UseRealTime();
  if (rows >= 10 * kSomeRows) made->Iterations(1);
}

}  // namespace

void RegisterGrowth(double most_rows) {
  const auto most = static_cast<std::size_t>(most_rows);
  for (std::size_t rows = 10000; rows <= most; rows *= 10) {
    // Three columns, the prediction they are made with, and as much again for the fit.
    const bool fits = static_cast<double>(rows) * 9 * sizeof(double) < AvailableBytes();
    const auto name = [rows](const char* what) { return std::string(what) + std::to_string(rows); };
    if (fits) {
      Register(name("GrowthRows/sweep/"), rows, [rows](benchmark::State& state) {
        GrowSweep(state, rows, kBranches, kTerms);
      });
      Register(name("GrowthRows/prepare/"), rows, [rows](benchmark::State& state) {
        GrowPreparation(state, rows);
      });
      Register(
          name("GrowthRows/fit/"), rows, [rows](benchmark::State& state) { GrowFit(state, rows); });
    }
    Register(name("GrowthRows/stream/"), rows, [rows](benchmark::State& state) {
      GrowStream(state, rows);
    });
  }
  const std::size_t rows = std::min(most, kSomeRows);
  for (int branches = 0; branches <= 5; ++branches) {
    Register("GrowthBranches/" + std::to_string(branches), rows, [=](benchmark::State& state) {
      GrowSweep(state, rows, branches, kTerms);
    });
  }
  for (const int terms : {5, 10, 20, 50, 100}) {
    Register("GrowthTerms/" + std::to_string(terms), rows, [=](benchmark::State& state) {
      GrowSweep(state, rows, kBranches, terms);
    });
  }
}

}  // namespace lipoid::bench
