#pragma once

/// @file
/// What the benchmarks take from the command line beside Google Benchmark's own options.

#include <string>

namespace lipoid::bench {

/// --csv-megabytes=N: size of the file that the CSV benchmarks make.
[[nodiscard]] double CsvMegabytes();

/// --csv-file=FILE: a plain CSV to read instead of making one; empty: make one.
[[nodiscard]] const std::string& CsvFile();

/// The benchmarks of growth, which --growth-rows=N bounds: registered by main, once N is known.
void RegisterGrowth(double most_rows);

}  // namespace lipoid::bench
