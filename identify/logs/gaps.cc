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
constexpr double kHour_s = 3600.0;
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

// An hour more than all intervals around, which are alike: the clock was put forward to summer time.
bool IsAnHourMore(std::span<const double> time_s, std::size_t row) {
  constexpr double kAlike = 0.01;
  const Extent around = FindExtent(Around(time_s, row));
  const double more_s = time_s[row] - time_s[row - 1] - around.most;
  return more_s > 0.0 && around.most - around.least <= kAlike * around.most &&
         std::abs(more_s - kHour_s) <= kAlike * around.most;
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
    const double before_s = time_s[k - 1] - time_s[k - 2];
    if (length_s <= kLonger * before_s && length_s < kHour_s) continue;  // most rows end here
    if (!OutOfProportion(time_s, k) && !IsAnHourMore(time_s, k)) continue;
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

// Of the highest voltage at rest so far: a cell that rests above is back there.
constexpr double kBack = 0.988;
// Of the voltage after a jump: no rest relaxes by as much in a row, once it has lasted for some.
constexpr double kJump = 0.025;
// Of the charge that the record moves, what has left since.
constexpr double kLeastGone = 0.1;
constexpr std::size_t kRowsAtRest = 3;  // on either side of the jump

// Most discharges are never as high again as in their first rows, which is seen without asking where they rest.
bool MayBeBack(std::span<const double> voltage_V) {
  const double high_V = kBack * FindExtent(voltage_V).most;
  const auto is_high = [&](double v) { return v >= high_V; };
  const auto first = std::find_if(voltage_V.begin(), voltage_V.end(), is_high);
  const auto last = std::find_if(voltage_V.rbegin(), voltage_V.rend(), is_high).base();
  return first < last && *std::min_element(first, last) <= (1.0 - kJump) * high_V;
}

}  // namespace

std::vector<Gap> FindUnseenRecharges(const Record& record) {
  const Column& v = record.voltage_V;
  if (v.size() < 3 || !MayBeBack(v)) return {};
  std::vector<Gap> recharges;
  const double rest_A = RestThreshold(record);
  const double range_C = CountCharge(record).range_C();
  const std::vector<double> left_C = DeliveredCharge(record);
  constexpr auto kNone = static_cast<std::size_t>(-1);
  std::size_t top = kNone;      // the highest rest since the last recharge
  std::size_t rested_rows = 0;  // up to this one, without a load between
  for (std::size_t k = 0; k < v.size(); ++k) {
    rested_rows = std::abs(record.current_A[k]) <= rest_A ? rested_rows + 1 : 0;
    // A current that changes its sign passes zero, and the drop of the one before is still there.
    if (rested_rows < kRowsAtRest) continue;
    const std::size_t first = k + 1 - kRowsAtRest;
    const double gone_C = top == kNone ? 0.0 : left_C[k] - left_C[top];
    const bool jumped =
        rested_rows >= 2 * kRowsAtRest && v[first] - v[first - 1] >= kJump * v[first];
    if (jumped && v[k] >= kBack * v[top] && gone_C >= kLeastGone * range_C) {
      recharges.push_back({.row = first,
                           .start_s = record.time_s[first - 1],
                           .length_s = record.time_s[first] - record.time_s[first - 1],
                           .unknown_C = gone_C,
                           .recharge = true});
      top = k;
    } else if (top == kNone || (v[k] > v[top] && gone_C < kLeastGone * range_C)) {
      top = k;
    }
  }
  return recharges;
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
  if (most.recharge) {
    return fmt::format(
        "{} of some {:.3g} Ah between {:.10g} and {:.10g} s, where the voltage at rest comes back without a "
        "current, as where a test begins anew",
        gaps.size() == 1 ? "a recharge"
                         : fmt::format("{} gaps, the largest a recharge", gaps.size()),
        most.unknown_C / 3600.0,
        most.start_s,
        most.start_s + most.length_s);
  }
  return fmt::format("{} of {:.4g} s after {:.10g} s, in which up to {:.3g} Ah may have flowed",
                     gaps.size() == 1 ? "a gap" : fmt::format("{} gaps, the largest", gaps.size()),
                     most.length_s,
                     most.start_s,
                     UnknownCharge(gaps) / 3600.0);
}

std::string GapsHint(const std::vector<Gap>& gaps) {
  const double length_s = LargestOf(gaps).length_s;
  return length_s > kHour_s && length_s <= 1.5 * kHour_s
             ? " (if a clock was put forward to summer time, export the time since the start)"
             : "";
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
          "expected rows wherever a current flows, found {}{}: the state of charge after it is "
          "not known; read the part before it (end_s = {:.10g}), or the part after it "
          "(start_s = {:.10g}) with its own initial_soc, or save the parts as files of their own (lipoid convert "
          "--end-s {:.10g}, and --start-s {:.10g})",
          GapsText(gaps),
          GapsHint(gaps),
          most.start_s,
          most.start_s + most.length_s,
          most.start_s,
          most.start_s + most.length_s));
}

}  // namespace lipoid
