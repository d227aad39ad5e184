#pragma once

/// @file
/// What the benchmarks take from the command line beside Google Benchmark's own options.

namespace lipoid::bench {

/// --csv-megabytes=N: size of the file that the CSV benchmarks make.
[[nodiscard]] double CsvMegabytes();

}  // namespace lipoid::bench
