#include "identify/logs/plausibility.h"

#include <fmt/format.h>

#include "identify/logs/columns.h"

namespace lipoid {
namespace {

// No pack has more than these; what was meant has a factor of 1000 less.
constexpr double kMostPack_V = 2000.0;
constexpr double kMostPack_A = 1e5;
constexpr double kLongest_s = 20 * 365.25 * 86400.0;

// One cell, from a half cell at rest to a lithium cell under fast charge.
constexpr double kMostCell_V = 6.0;
constexpr double kLeastCell_V = 0.02;
// Charge between the fullest and the emptiest moment of a log, in capacities; and C-rate.
constexpr double kMostCapacities = 5.0;
constexpr double kMostRate_per_h = 500.0;

}  // namespace

void CheckReadable(const Record& record, const ColumnPositions& positions) {
  if (const double most_V = LargestMagnitude(record.voltage_V); most_V > kMostPack_V) {
    throw LoadError(
        positions.voltage,
        fmt::format(
            "expected a voltage in V, found {:.6g} V; are these mV? Say so in the header or with "
            "`units`",
            most_V));
  }
  if (const double most_A = LargestMagnitude(record.current_A); most_A > kMostPack_A) {
    throw LoadError(
        positions.current,
        fmt::format(
            "expected a current in A, found {:.6g} A; are these mA? Say so in the header or with "
            "`units`",
            most_A));
  }
  if (record.size() < 2) return;
  if (const double length_s = record.time_s.back() - record.time_s.front(); length_s > kLongest_s) {
    throw LoadError(
        positions.time,
        fmt::format(
            "expected times in s, found a log of {:.3g} years; are these ms? Say so in the header "
            "or with `units`",
            length_s / (365.25 * 86400.0)));
  }
}

void CheckPlausible(const Record& record, double capacity_Ah) {
  if (record.voltage_V.empty()) return;
  const double mean_V = Sum(record.voltage_V) / static_cast<double>(record.size());
  if (mean_V > kMostCell_V) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected the voltage of one cell, found {:.4g} V on average; are these mV, or is it a "
            "pack (say `series`)?",
            mean_V));
  }
  if (const double most_V = LargestMagnitude(record.voltage_V); most_V < kLeastCell_V) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected the voltage of one cell, found {:.3g} V at most; are these V under a header "
            "that says mV, or is `series` too large?",
            most_V));
  }
  if (!(capacity_Ah > 0.0)) return;
  const double most_A = LargestMagnitude(record.current_A);
  if (most_A > kMostRate_per_h * capacity_Ah) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected the current of one cell of {:.4g} Ah, found {:.4g} A; are these mA, is it a "
            "pack (say `parallel`), or is the capacity wrong?",
            capacity_Ah,
            most_A));
  }
  const ChargeMoved moved = CountCharge(record, 0, record.size() - 1);
  if (const double range_Ah = (moved.most_C - moved.least_C) / 3600.0;
      range_Ah > kMostCapacities * capacity_Ah) {
    throw LoadError(
        {record.file},
        fmt::format(
            "expected charges of one cell of {:.4g} Ah, found {:.4g} Ah going one way; are the "
            "units of time and current right, is it a pack (say `parallel`), or has the current "
            "no sign?",
            capacity_Ah,
            range_Ah));
  }
}

}  // namespace lipoid
