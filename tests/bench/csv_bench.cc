// Reading and writing plain CSV: bytes per second on one core, after the sums of the columns were
// checked.
//
//   lipoid_bench --benchmark_filter=ReadLog --csv-megabytes=200
//
// The file is made by this program: a pulse log at 10 ms with the shortest digits that read back.
// Another one is read by --csv-file=FILE (time_s,current_A,voltage_V); its sums are then those of a
// plain reader.
#include <benchmark/benchmark.h>
#include <sys/resource.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string>

#include "identify/logs/csv/table_reader.h"
#include "identify/logs/log.h"
#include "identify/logs/log_writer.h"
#include "tests/bench/bench_options.h"
#include "tests/support/plain_csv.h"

namespace lipoid {
namespace {

struct Sums {
  double time_s = 0.0;
  double current_A = 0.0;
  double voltage_V = 0.0;

  void Add(double t_s, double i_A, double v_V) {
    time_s += t_s;
    current_A += i_A;
    voltage_V += v_V;
  }
  friend bool operator==(const Sums&, const Sums&) = default;
};

// 30 s pulses of 3.6 A with 30 s rests, both noisy, on a voltage that falls slowly.
Record PulseLog(std::size_t rows) {
  std::mt19937_64 random(20240917);
  std::normal_distribution<double> noise(0.0, 1.0);
  Record record;
  record.time_s.reserve(rows);
  record.current_A.reserve(rows);
  record.voltage_V.reserve(rows);
  for (std::size_t k = 0; k < rows; ++k) {
    const double i_A = (k / 3000) % 2 == 1 ? 3.6 + 1e-3 * noise(random) : 1e-4 * noise(random);
    record.time_s.push_back(static_cast<double>(k) / 100.0);
    record.current_A.push_back(i_A);
    record.voltage_V.push_back(4.2 - 0.9 * static_cast<double>(k) / static_cast<double>(rows) -
                               0.13 * i_A + 2e-4 * noise(random));
  }
  return record;
}

struct LogFile {
  LogFile() = default;
  LogFile(const LogFile&) = delete;
  LogFile& operator=(const LogFile&) = delete;
  ~LogFile() {
    if (bench::CsvFile().empty()) std::filesystem::remove(path);
  }

  void Make() {
    constexpr double kBytesPerRow = 46.0;
    const auto count = static_cast<std::size_t>(bench::CsvMegabytes() * 1e6 / kBytesPerRow);
    const Record record = PulseLog(count);
    Take(record);
    WriteLog(record, path);
    bytes = std::filesystem::file_size(path);
  }
  void Find() {
    path = bench::CsvFile();
    Take(test::ReadPlainCsv(path));
    bytes = std::filesystem::file_size(path);
  }
  void Take(const Record& record) {
    rows = record.size();
    for (std::size_t k = 0; k < rows; ++k)
      sums.Add(record.time_s[k], record.current_A[k], record.voltage_V[k]);
  }

  std::string path =
      (std::filesystem::temp_directory_path() / ("lipoid_csv_bench." + std::to_string(::getpid())))
          .string();
  std::size_t rows = 0;
  std::uintmax_t bytes = 0;
  Sums sums;
};

// Written, or read by other means, once per run of the program.
const LogFile& File() {
  static LogFile made;
  if (made.rows > 0) return made;
  if (bench::CsvFile().empty()) {
    made.Make();
  } else {
    made.Find();
  }
  return made;
}

double PeakResidentMegabytes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;
}

// The engine alone: text to columns of doubles, block by block.
void ReadTable(benchmark::State& state) {
  const LogFile& file = File();
  const auto read = [&](Sums& sums) {
    TextSource source(file.path);
    source.Skip(source.head().find('\n') + 1);
    TableSpec spec;
    spec.first_line = 2;
    spec.fields = 3;
    spec.columns = {{.name = "time_s", .field = 0},
                    {.name = "current_A", .field = 1},
                    {.name = "voltage_V", .field = 2}};
    TableReader reader(source, spec);
    TableBlock block;
    std::size_t rows = 0;
    while (reader.NextBlock(block)) {
      for (std::size_t k = 0; k < block.rows; ++k)
        sums.Add(block.columns[0][k], block.columns[1][k], block.columns[2][k]);
      rows += block.rows;
    }
    return rows;
  };
  Sums sums;
  if (read(sums) != file.rows || !(sums == file.sums)) {
    state.SkipWithError("the columns do not add up to what was written");
    return;
  }
  for (auto _ : state) {
    Sums again;
    benchmark::DoNotOptimize(read(again));
  }
  state.SetBytesProcessed(static_cast<std::int64_t>(file.bytes) * state.iterations());
  state.SetItemsProcessed(static_cast<std::int64_t>(file.rows) * state.iterations());
  state.counters["peak_MB"] = PeakResidentMegabytes();
}
BENCHMARK(ReadTable)->Unit(benchmark::kMillisecond)->UseRealTime();

// All that ReadLog does: recognition, columns kept, sign of the current, gaps.
void ReadWholeLog(benchmark::State& state) {
  const LogFile& file = File();
  {
    const Log log = ReadLog(file.path);
    Sums sums;
    for (std::size_t k = 0; k < log.record.size(); ++k) {
      sums.Add(log.record.time_s[k], log.record.current_A[k], log.record.voltage_V[k]);
    }
    if (log.record.size() != file.rows || !(sums == file.sums)) {
      state.SkipWithError("the columns do not add up to what was written");
      return;
    }
  }
  for (auto _ : state) benchmark::DoNotOptimize(ReadLog(file.path).record.voltage_V.back());
  state.SetBytesProcessed(static_cast<std::int64_t>(file.bytes) * state.iterations());
  state.SetItemsProcessed(static_cast<std::int64_t>(file.rows) * state.iterations());
  state.counters["kept_MB"] = static_cast<double>(file.rows) * 3 * sizeof(double) / 1e6;
  state.counters["peak_MB"] = PeakResidentMegabytes();
}
BENCHMARK(ReadWholeLog)->Unit(benchmark::kMillisecond)->UseRealTime();

void WriteCsv(benchmark::State& state) {
  const LogFile& file = File();
  const Record record = PulseLog(file.rows);
  const std::string path = file.path + ".written";
  for (auto _ : state) WriteLog(record, path);
  if (std::filesystem::file_size(path) != file.bytes)
    state.SkipWithError("the file has another size");
  std::filesystem::remove(path);
  state.SetBytesProcessed(static_cast<std::int64_t>(file.bytes) * state.iterations());
}
BENCHMARK(WriteCsv)->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
}  // namespace lipoid
