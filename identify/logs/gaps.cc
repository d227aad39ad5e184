#include "identify/logs/gaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>

#include "identify/logs/columns.h"
#include "identify/logs/segments.h"
#include "model/core/errors.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

constexpr double kLonger = 10.0;
constexpr std::size_t kNeighbours = 5;
// Intervals that differ by more than this among neighbours are those of a logger that writes a row
// when something changes.
constexpr double kIrregular = 3.0;

// How much rows first .. last, as far as there are such, differ from those before them.
std::vector<double> Differences(std::span<const double> column,
                                std::size_t first,
                                std::size_t last) {
  std::vector<double> differences;
  for (std::size_t k = first; k <= last && k < column.size(); ++k)
    differences.push_back(std::abs(column[k] - column[k - 1]));
  return differences;
}

std::size_t FirstBefore(std::size_t row) { return row > kNeighbours ? row - kNeighbours : 1; }

// Of the rows up to five intervals before and after the one that ends at `row`; there is one before.
std::vector<double> Around(std::span<const double> column, std::size_t row) {
  std::vector<double> around = Differences(column, FirstBefore(row), row - 1);
  const std::vector<double> after = Differences(column, row + 1, row + kNeighbours);
  around.insert(around.end(), after.begin(), after.end());
  return around;
}

bool OutOfProportion(std::span<const double> time_s, std::size_t row) {
  const double before_s = UpperMedian(Differences(time_s, FirstBefore(row), row - 1));
  const double after_s = UpperMedian(Differences(time_s, row + 1, row + kNeighbours));
  return time_s[row] - time_s[row - 1] > kLonger * std::fmax(before_s, after_s);
}

// A logger that writes a row when something changes had nothing to write.
bool NothingChanged(const Record& record, std::size_t row) {
  const Extent intervals = FindExtent(Around(record.time_s, row));
  if (!(intervals.most > kIrregular * intervals.least)) return false;
  const auto moved_no_more = [row](std::span<const double> column) {
    return column.empty() ||
           std::abs(column[row] - column[row - 1]) <= LargestMagnitude(Around(column, row));
  };
  return moved_no_more(record.current_A) && moved_no_more(record.voltage_V);
}

// A cell that rests after a discharge recovers, and after a charge the other way round. Whether the voltage
// moves against that, as where a load flowed that nobody saw.
bool HidesALoad(const Record& record, std::size_t row, double rest_A) {
  constexpr double kOfVoltage =
      5e-3;                       // no self-discharge and no change of temperature makes so much
  constexpr double kNoise = 3.0;  // multiples of what neighbouring rows differ by
  const Column& voltage_V = record.voltage_V;
  if (voltage_V.empty()) return false;
  const double fall_V = voltage_V[row - 1] - voltage_V[row];
  if (std::abs(fall_V) <= std::max(kOfVoltage * std::abs(voltage_V[row - 1]),
                                   kNoise * UpperMedian(Around(voltage_V, row))))
    return false;
  std::size_t load = row - 1;
  while (load > 0 && std::abs(record.current_A[load]) <= rest_A) --load;
  const double last_A = record.current_A[load];
  return std::abs(last_A) > rest_A && (last_A > 0.0) == (fall_V > 0.0);
}

}  // namespace

std::vector<Gap> FindGaps(const Record& record) {
  std::vector<Gap> gaps;
  const Column& time_s = record.time_s;
  double rest_A = -1.0;  // not known before it is needed: most logs have no long interval
  for (std::size_t k = 2; k < time_s.size(); ++k) {
    const double length_s = time_s[k] - time_s[k - 1];
    if (length_s <= kLonger * (time_s[k - 1] - time_s[k - 2])) continue;  // most rows end here
    if (!OutOfProportion(time_s, k)) continue;
    if (rest_A < 0.0) rest_A = RestThreshold(record);
    const bool at_rest =
        std::abs(record.current_A[k - 1]) <= rest_A && std::abs(record.current_A[k]) <= rest_A;
    if ((at_rest && !HidesALoad(record, k, rest_A)) || NothingChanged(record, k)) continue;
    const double most_A =
        at_rest ? LargestMagnitude(record.current_A)
                : std::max(std::abs(record.current_A[k - 1]), std::abs(record.current_A[k]));
    gaps.push_back(
        {.row = k, .start_s = time_s[k - 1], .length_s = length_s, .unknown_C = length_s * most_A});
  }
  return gaps;
}

namespace {

double UnknownCharge(const std::vector<Gap>& gaps) {
  double unknown_C = 0.0;
  for (const Gap& gap : gaps) unknown_C += gap.unknown_C;
  return unknown_C;
}

const Gap& LargestOf(const std::vector<Gap>& gaps) {
  return *std::max_element(gaps.begin(), gaps.end(), [](const Gap& a, const Gap& b) {
    return a.unknown_C < b.unknown_C;
  });
}

}  // namespace

std::string GapsText(const std::vector<Gap>& gaps) {
  const Gap& most = LargestOf(gaps);
  return fmt::format("{} of {:.4g} s after {:.10g} s, in which up to {:.3g} Ah may have flowed",
                     gaps.size() == 1 ? "a gap" : fmt::format("{} gaps, the largest", gaps.size()),
                     most.length_s,
                     most.start_s,
                     UnknownCharge(gaps) / 3600.0);
}

void RefuseUnknownCharge(const Record& record,
                         const std::vector<Gap>& gaps,
                         double capacity_Ah,
                         double most_share) {
  if (gaps.empty() || record.voltage_V.empty()) return;
  const double capacity_C =
      capacity_Ah > 0.0 ? 3600.0 * capacity_Ah : CountCharge(record).range_C();
  if (UnknownCharge(gaps) <= most_share * capacity_C) return;
  const Gap& most = LargestOf(gaps);
  throw LoadError(
      {record.file},
      fmt::format(
          "expected rows wherever a current flows, found {}: the state of charge after it is "
          "not known; read the part before it (end_s = {:.10g}), or the part after it "
          "(start_s = {:.10g}) with its own initial_soc, or save the parts as files of their own (lipoid convert "
          "--end-s {:.10g}, and --start-s {:.10g})",
          GapsText(gaps),
          most.start_s,
          most.start_s + most.length_s,
          most.start_s,
          most.start_s + most.length_s));
}

}  // namespace lipoid
