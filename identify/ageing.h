#pragma once

/// @file
/// What changed between cells that were identified from one cell at several ages: capacity, beta and
/// the resistance that a pulse shows, each against the first age, with its interval.
///
/// The estimates of two ages are independent: on a scale of logarithms each side of the 95 % interval
/// of their ratio is the root of the squared sum of the sides that make it. A change whose interval
/// holds zero is not shown by these logs, which does not mean that there was none. Numbers of
/// another temperature than that of the first are shown and not compared, nor those of a cell that
/// knows its temperature with those of one that does not: a cell in the cold gives less. Cells that both know
/// what temperature does have one capacity. Nothing is compared with a cell that does not
/// describe its own logs. Tests: tests/identify/ageing_test.cc.

#include <string>
#include <utility>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

enum class ChangeVerdict {
  kFirst,
  kChanged,
  kNotShown,
  kNoInterval,
  kNotKnown,
  kFirstNotKnown,
  kOtherTemperature,
  kTemperatureNotKnown,
  kPoorFit
};
constexpr std::array<std::pair<ChangeVerdict, std::string_view>, 9> OptionNames(ChangeVerdict) {
  return {{{ChangeVerdict::kFirst, "first"},
           {ChangeVerdict::kChanged, "changed"},
           {ChangeVerdict::kNotShown, "not shown by these logs"},
           {ChangeVerdict::kNoInterval, "no interval"},
           {ChangeVerdict::kNotKnown, "not known"},
           {ChangeVerdict::kFirstNotKnown, "not known of the first"},
           {ChangeVerdict::kOtherTemperature, "of another temperature"},
           {ChangeVerdict::kTemperatureNotKnown, "temperature not known"},
           {ChangeVerdict::kPoorFit, "of a poor fit"}}};
}

/// A quantity at one age. NaN: not known.
struct AgedValue {
  double value, low, high;
  double change_percent;                           ///< against the first age
  double change_low_percent, change_high_percent;  ///< its interval
  ChangeVerdict verdict;
};

struct AgedQuantity {
  std::string name;  ///< capacity, beta, resistance_1s, ...
  std::string what;  ///< the same in words
  std::string unit;
  std::vector<AgedValue> at;  ///< one for each cell
};

/// The cells in the order of their ages, with the run records that `identify` writes into them: from
/// there the intervals come.
[[nodiscard]] std::vector<AgedQuantity> CompareAges(const std::vector<Cell>& cells);

/// What makes it doubtful that these are ages of one cell, the youngest first: a capacity that grew, or
/// of which more than half is gone. One sentence for each such cell, by its place in the list.
[[nodiscard]] std::vector<std::pair<std::size_t, std::string>> DoubtsAboutAges(
    const std::vector<AgedQuantity>& quantities);

/// Why changes may be those of a temperature that no cell file knows. "" where one of them does.
[[nodiscard]] std::string DoubtAboutTemperatures(const std::vector<Cell>& cells);

/// The age that the campaign of a cell gave it; "" where it gave none.
[[nodiscard]] std::string AgeOf(const Cell& cell);

}  // namespace lipoid
