// All benchmarks of lipoid in one program; --help lists Google Benchmark's options.
#include <benchmark/benchmark.h>

#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "tests/bench/bench_options.h"

namespace lipoid::bench {
namespace {
double csv_megabytes = 150.0;
std::string csv_file;
double growth_rows = 1e5;

// Whether the argument is `option`VALUE; the value is then handed to `take`.
template <class Take>
bool Takes(std::string_view argument, std::string_view option, Take&& take) {
  if (!argument.starts_with(option)) return false;
  take(argument.data() + option.size());
  return true;
}

bool TakesAny(const char* argument) {
  return Takes(argument, "--csv-megabytes=", [](const char* n) { csv_megabytes = std::atof(n); }) ||
         Takes(argument, "--csv-file=", [](const char* file) { csv_file = file; }) ||
         Takes(argument, "--growth-rows=", [](const char* n) { growth_rows = std::atof(n); });
}

}  // namespace

double CsvMegabytes() { return csv_megabytes; }
const std::string& CsvFile() { return csv_file; }

}  // namespace lipoid::bench

int main(int count, char** arguments) {
  benchmark::Initialize(&count, arguments);
  for (int k = 1; k < count; ++k) {
    if (lipoid::bench::TakesAny(arguments[k])) continue;
    std::fprintf(stderr,
                 "unknown option %s; known: --csv-megabytes=N --csv-file=FILE --growth-rows=N\n",
                 arguments[k]);
    return 2;
  }
  lipoid::bench::RegisterGrowth(lipoid::bench::growth_rows);
  benchmark::RunSpecifiedBenchmarks();
  return 0;
}
