#include "identify/logs/spikes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <span>

#include "identify/logs/columns.h"
#include "model/core/special_values.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

constexpr double kLeastJump_V = 0.2;
// Of the range of the other rows.
constexpr double kBeyond = 0.5;
// Of the largest current nearby: a step of the current may have moved the voltage.
constexpr double kStepOfCurrent = 0.1;

// The jump towards a row and back again, the smaller one; 0 where the voltage goes on in the same
// direction.
double JumpAndBack(std::span<const double> v, std::size_t row) {
  const double before = v[row] - v[row - 1];
  const double after = v[row] - v[row + 1];
  return before * after > 0.0 ? std::min(std::abs(before), std::abs(after)) : 0.0;
}

// Of the jumps towards rows [first, end), several runs at a time.
double LargestJump(std::span<const double> v, std::size_t first, std::size_t end) {
  std::array<double, 4> largest{};
  std::size_t k = first;
  for (; k + largest.size() <= end; k += largest.size()) {
    for (std::size_t lane = 0; lane < largest.size(); ++lane)
      largest[lane] = std::max(largest[lane], std::abs(v[k + lane] - v[k + lane - 1]));
  }
  for (; k < end; ++k) largest[0] = std::max(largest[0], std::abs(v[k] - v[k - 1]));
  return *std::max_element(largest.begin(), largest.end());
}

// The current changes towards the row and back, both times the other way than the voltage.
bool CurrentExplains(const Record& record, std::size_t row) {
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  const double largest = std::max({std::abs(i[row]), std::abs(i[row - 1]), std::abs(i[row + 1])});
  const auto steps = [&](std::size_t other) {
    const double step_A = i[row] - i[other];
    return std::abs(step_A) > kStepOfCurrent * largest && step_A * (v[row] - v[other]) < 0.0;
  };
  return steps(row - 1) && steps(row + 1);
}

// A few rows among others whose voltage is next to none, as where a sensor did not answer: whatever flows, no cell has
// it.
std::vector<std::size_t> FindDeadRows(const Column& v) {
  constexpr double kDead = 0.1;  // of the usual voltage
  constexpr std::size_t kMost = 5;
  const Extent extent = FindExtent(v);
  if (!(extent.least < kDead * extent.most)) return {};
  const double dead_V = kDead * Median(std::vector<double>(v.begin(), v.end()));
  std::vector<std::size_t> rows;
  for (std::size_t k = 0; k < v.size();) {
    const std::size_t first = k;
    while (k < v.size() && v[k] < dead_V) ++k;
    if (k > first && k - first <= kMost) {
      for (std::size_t row = first; row < k; ++row) rows.push_back(row);
    }
    k = std::max(k, first + 1);
  }
  return rows;
}

// The extent of all rows but some, in their order.
Extent ExtentWithout(std::span<const double> values, const std::vector<std::size_t>& rows) {
  Extent others;
  std::size_t from = 0;
  const auto take = [&](std::size_t to) {
    const Extent part = FindExtent(values.subspan(from, to - from));
    others.least = std::min(others.least, part.least);
    others.most = std::max(others.most, part.most);
    from = to + 1;
  };
  for (const std::size_t row : rows) take(row);
  take(values.size());
  return others;
}

// Rows that are reached by a jump of more than this and left by one back.
std::vector<std::size_t> JumpsAndBacks(std::span<const double> values, double least) {
  // Most pieces have no jump at all, which is seen without looking at each row.
  constexpr std::size_t kPiece = 1024;
  std::vector<std::size_t> rows;
  for (std::size_t first = 1; first + 1 < values.size(); first += kPiece) {
    const std::size_t end = std::min(first + kPiece, values.size() - 1);
    if (LargestJump(values, first, end) <= least) continue;
    for (std::size_t k = first; k < end; ++k) {
      if (JumpAndBack(values, k) > least) rows.push_back(k);
    }
  }
  return rows;
}

// What steps of the current do to the voltage, in the row or the one after it: the median of some that
// are at least half the range of the current, and touch none of `without`. NaN where there are none.
double OhmsOfSteps(const Record& record, double range_A, const std::vector<std::size_t>& without) {
  constexpr std::size_t kEnough = 31;
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  std::vector<double> ohms;
  for (std::size_t k = 1; k + 1 < v.size() && ohms.size() < kEnough; ++k) {
    const double step_A = std::abs(i[k] - i[k - 1]);
    if (!(step_A >= 0.5 * range_A)) continue;
    const auto near = std::lower_bound(without.begin(), without.end(), k - 1);
    if (near != without.end() && *near <= k) continue;
    ohms.push_back(std::max(std::abs(v[k] - v[k - 1]), std::abs(v[k + 1] - v[k - 1])) / step_A);
  }
  return ohms.empty() ? kNaN : Median(std::move(ohms));
}

// Of one end: how many rows. `inward(k)` is the row that is k rows from it.
template <class Inward>
std::size_t WithoutCell(const Record& record, double largest_A, const Inward& inward) {
  constexpr double kRest = 1e-3;  // of the largest current
  // A charge that ends leaves a lower voltage, too, but never one like this; which sign charges is not known yet.
  constexpr double kNoCell = 0.6;  // of the least of the others
  constexpr int kMostSteps = 20;   // down to the voltage of an open lead
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  const auto at_rest = [&](std::size_t row) { return std::abs(i[row]) <= kRest * largest_A; };
  std::size_t rows = 0;
  double usual_V = 0.0;
  double highest_V = -std::numeric_limits<double>::infinity();
  for (int steps = 0; rows + 1 < v.size() && at_rest(inward(rows)) && steps < kMostSteps;) {
    highest_V = std::max(highest_V, v[inward(rows)]);
    const std::size_t next = inward(++rows);
    if (v[next] - highest_V < kLeastJump_V) continue;
    if (steps++ == 0) usual_V = Median(std::vector<double>(v.begin(), v.end()));
    Extent others;
    for (std::size_t k = rows; k < v.size(); ++k) {
      const std::size_t row = inward(k);
      if (at_rest(row) && v[row] < kNoCell * usual_V) continue;  // the same at the other end
      others.least = std::min(others.least, v[row]);
      others.most = std::max(others.most, v[row]);
    }
    const double margin_V = std::max(kLeastJump_V, kBeyond * (others.most - others.least));
    const bool lower =
        at_rest(next) ? highest_V < others.least - margin_V : highest_V < kNoCell * others.least;
    if (lower) return rows;
  }
  return 0;
}

}  // namespace

RowsWithoutCell FindRowsWithoutCell(const Record& record) {
  const std::size_t size = record.voltage_V.size();
  if (size < 4) return {};
  const Extent current = FindExtent(record.current_A);
  const double largest_A = std::max(std::abs(current.least), std::abs(current.most));
  if (!(largest_A > 0.0)) return {};
  return {.first = WithoutCell(record, largest_A, [](std::size_t k) { return k; }),
          .last = WithoutCell(record, largest_A, [&](std::size_t k) { return size - 1 - k; })};
}

std::vector<std::size_t> FindCurrentSpikes(const Record& record) {
  const Column& i = record.current_A;
  const Column& v = record.voltage_V;
  if (v.size() < 4) return {};
  const Extent all = FindExtent(i);
  // What leaves the range of the others by half of it is a third of the whole, at least.
  constexpr double kThird = 0.33;
  std::vector<std::size_t> rows = JumpsAndBacks(i, kThird * (all.most - all.least));
  if (rows.empty()) return {};
  const Extent others = ExtentWithout(i, rows);
  if (!(others.least <= others.most)) return {};
  const double range_A = others.most - others.least;
  const double largest_A = std::max(std::abs(others.least), std::abs(others.most));
  const double margin_A = kBeyond * std::max(range_A, largest_A);
  std::erase_if(rows, [&](std::size_t row) {
    return i[row] <= others.most + margin_A && i[row] >= others.least - margin_A;
  });
  if (rows.empty()) return {};
  const double ohms = OhmsOfSteps(record, range_A, rows);
  // Rests among which single rows carry all the load are a slow logger's pulses.
  const bool steady = std::min(std::abs(others.least), std::abs(others.most)) >= 0.5 * largest_A &&
                      others.least * others.most > 0.0;
  if (std::isnan(ohms) && !steady) return {};
  std::erase_if(rows, [&](std::size_t row) {
    const double step_A = JumpAndBack(i, row);
    double moved_V = std::abs(v[row] - v[row - 1]);
    for (std::size_t k = row + 1; k < std::min(row + 3, v.size()); ++k)
      moved_V = std::max(moved_V, std::abs(v[k] - v[k - 1]));
    constexpr double kFollows = 0.25;
    constexpr double kStill_V = 0.005;
    constexpr double kManyTimes = 5.0;
    return std::isnan(ohms) ? moved_V > kStill_V || step_A < kManyTimes * largest_A
                            : !(moved_V < kFollows * ohms * step_A);
  });
  // Readings that fail are few; more are a load that the rows are too far apart to show.
  constexpr std::size_t kMost = 5;
  return rows.size() <= kMost ? rows : std::vector<std::size_t>{};
}

std::vector<std::size_t> FindSpikes(const Record& record) {
  const Column& v = record.voltage_V;
  if (v.size() < 4) return {};
  const std::vector<std::size_t> dead = FindDeadRows(v);
  std::vector<std::size_t> candidates = JumpsAndBacks(v, kLeastJump_V);
  candidates.insert(candidates.end(), dead.begin(), dead.end());
  if (candidates.empty()) return {};
  std::sort(candidates.begin(), candidates.end());
  candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
  const Extent others = ExtentWithout(v, candidates);
  if (!(others.least <= others.most)) return {};
  const double margin_V = std::max(kLeastJump_V, kBeyond * (others.most - others.least));
  std::erase_if(candidates, [&](std::size_t row) {
    if (std::binary_search(dead.begin(), dead.end(), row)) return false;
    const bool beyond = v[row] > others.most + margin_V || v[row] < others.least - margin_V;
    return !beyond || CurrentExplains(record, row);
  });
  return candidates;
}

FailedTemperatures FindFailedTemperatures(std::span<const double> time_s,
                                          std::span<const double> temperature_degC) {
  constexpr double kJump_K = 8.0;
  constexpr double kJump_K_per_s = 0.5;
  constexpr double kBack_K = 3.0;
  constexpr double kBack_K_per_s = 0.05;
  constexpr std::size_t kFew = 5;
  const std::size_t size = temperature_degC.size();
  const auto jumps = [&](std::size_t k) {
    const double jump_K = std::abs(temperature_degC[k] - temperature_degC[k - 1]);
    return jump_K >= kJump_K && jump_K >= kJump_K_per_s * (time_s[k] - time_s[k - 1]);
  };
  FailedTemperatures failed;
  if (size <= 2 * kFew) return failed;  // which of them would be the odd ones?
  const auto add = [&](std::size_t first, std::size_t next) {
    for (std::size_t k = first; k < next; ++k) failed.rows.push_back(k);
  };
  for (std::size_t k = 1; k < size; ++k) {
    if (!jumps(k)) continue;
    std::size_t back = k + 1;
    const auto is_back = [&](std::size_t row) {
      return jumps(row) && std::abs(temperature_degC[row] - temperature_degC[k - 1]) <=
                               kBack_K + kBack_K_per_s * (time_s[row] - time_s[k - 1]);
    };
    while (back < size && !is_back(back)) ++back;
    if (k <= kFew && failed.rows.empty() && back - k > kFew) {
      add(0, k);
    } else if (back < size) {
      add(k, back);
      k = back;
    } else if (size - k <= kFew) {
      add(k, size);
      break;
    } else {
      failed.no_way_back = k;
      break;
    }
  }
  return failed;
}

}  // namespace lipoid
