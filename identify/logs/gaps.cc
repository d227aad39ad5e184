#include "identify/logs/gaps.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "identify/logs/columns.h"
#include "identify/logs/segments.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kLonger = 10.0;
constexpr std::size_t kNeighbours = 5;
// Intervals that differ by more than this among neighbours are those of a logger that writes a row
// when something changes.
constexpr double kIrregular = 3.0;

// The differences of neighbouring rows that end at rows first .. last, without row `gap`.
struct Neighbours {
  std::array<double, 2 * kNeighbours> values{};
  std::size_t count = 0;

  void Add(std::span<const double> column, std::size_t first, std::size_t last) {
    for (std::size_t k = first; k <= last && k < column.size() && count < values.size(); ++k)
      values[count++] = std::abs(column[k] - column[k - 1]);
  }
  [[nodiscard]] double Median() {
    if (count == 0) return 0.0;
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(count / 2);
    std::nth_element(values.begin(), middle, values.begin() + static_cast<std::ptrdiff_t>(count));
    return *middle;
  }
  [[nodiscard]] double Largest() const {
    return count == 0 ? 0.0 : *std::max_element(values.begin(), values.begin() + count);
  }
  [[nodiscard]] double Least() const {
    return count == 0 ? 0.0 : *std::min_element(values.begin(), values.begin() + count);
  }
};

std::size_t FirstBefore(std::size_t row) { return row > kNeighbours ? row - kNeighbours : 1; }

// The rows that end up to five intervals before and after the one that ends at `row`.
Neighbours Around(std::span<const double> column, std::size_t row) {
  Neighbours around;
  around.Add(column, FirstBefore(row), row - 1);
  around.Add(column, row + 1, row + kNeighbours);
  return around;
}

bool OutOfProportion(std::span<const double> time_s, std::size_t row) {
  Neighbours before;
  before.Add(time_s, FirstBefore(row), row - 1);
  Neighbours after;
  after.Add(time_s, row + 1, row + kNeighbours);
  return time_s[row] - time_s[row - 1] > kLonger * std::max(before.Median(), after.Median());
}

// A logger that writes a row when something changes had nothing to write.
bool NothingChanged(const Record& record, std::size_t row) {
  const Neighbours intervals = Around(record.time_s, row);
  if (!(intervals.Largest() > kIrregular * intervals.Least())) return false;
  const auto moved_no_more = [row](std::span<const double> column) {
    return column.empty() ||
           std::abs(column[row] - column[row - 1]) <= Around(column, row).Largest();
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
  if (std::abs(fall_V) <=
      std::max(kOfVoltage * std::abs(voltage_V[row - 1]), kNoise * Around(voltage_V, row).Median()))
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
          "(start_s = {:.10g}) with its own initial_soc",
          GapsText(gaps),
          most.start_s,
          most.start_s + most.length_s));
}

}  // namespace lipoid
