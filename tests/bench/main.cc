// All benchmarks of lipoid in one program; --help lists Google Benchmark's options.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/bench/bench_options.h"

namespace lipoid::bench {
namespace {
double csv_megabytes = 150.0;
}  // namespace

double CsvMegabytes() { return csv_megabytes; }

}  // namespace lipoid::bench

int main(int count, char** arguments) {
  benchmark::Initialize(&count, arguments);
  for (int k = 1; k < count; ++k) {
    constexpr std::string_view kCsv = "--csv-megabytes=";
    const std::string_view argument = arguments[k];
    if (!argument.starts_with(kCsv)) {
      std::fprintf(stderr, "unknown option %s; known: %sN\n", arguments[k], kCsv.data());
      return 2;
    }
    lipoid::bench::csv_megabytes = std::atof(arguments[k] + kCsv.size());
  }
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
