#pragma once

/// @file
/// A bench table: what a motor with its propeller gave on a thrust stand, row by row, as vendors
/// print it. A CSV file with a header; columns are found by their names, units stand in the header:
///
///   Throttle (%),Voltage (V),Current (A),Thrust (g),RPM
///   50,16.66,3.09,401,5688
///
/// Throttle in %, in us of pulse width from 1000 to 2000, or as a fraction without a unit; thrust in
/// g, kg or N; speed in rpm or rad/s, which may be missing. Other columns are left out. Numbers have
/// a decimal comma where another delimiter leaves it free. A row whose propeller stands says nothing
/// and is left out, and copies of a row count once. Tests: tests/identify/vehicle/bench_table_test.cc.

#include <string>
#include <vector>

namespace lipoid {

struct BenchRow {
  double throttle = 0.0;  ///< above 0 and at most 1
  double voltage_V = 0.0;
  double current_A = 0.0;  ///< of the battery
  double thrust_N = 0.0;
  double speed_rad_per_s = 0.0;  ///< 0 where the table has no speeds

  friend bool operator==(const BenchRow&, const BenchRow&) = default;
};

struct BenchTable {
  std::vector<BenchRow> rows;
  bool has_speed = false;
  std::vector<std::string> remarks = {};  ///< sentences on rows that were left out
};

/// LoadError with line and column for a header without one of the columns or without a unit that is
/// known, for numbers that are none and for values that no stand gives.
[[nodiscard]] BenchTable ReadBenchTable(const std::string& file);
[[nodiscard]] BenchTable ParseBenchTable(const std::string& text, const std::string& file);

}  // namespace lipoid
