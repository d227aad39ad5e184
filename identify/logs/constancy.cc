#include "identify/logs/constancy.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "identify/logs/columns.h"
#include "model/core/errors.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Current and duration of consecutive groups of rows.
struct Stretch {
  double current_A = 0.0;
  double duration_s = 0.0;
};

template <class Visit>
void ForEachStretch(
    const Record& record, std::size_t first, std::size_t last, std::size_t rows, Visit visit) {
  if (rows == 1) {
    for (std::size_t k = first; k <= last; ++k) {
      const double duration_s = RowDuration(record, k);
      if (duration_s > 0.0) visit(Stretch{record.current_A[k], duration_s});
    }
    return;
  }
  for (std::size_t k = first; k <= last;) {
    const std::size_t end = std::min(last - k < rows ? last + 1 : k + rows, last + 1);
    double charge_C = 0.0;
    double duration_s = 0.0;
    for (; k < end; ++k) {
      const double dt_s = RowDuration(record, k);
      charge_C += record.current_A[k] * dt_s;
      duration_s += dt_s;
    }
    if (duration_s > 0.0) visit(Stretch{charge_C / duration_s, duration_s});
  }
}

// The currents of stretches, and their median over time to kBins parts of their range, without
// sorting.
struct Level {
  Extent current_A;
  double median_A = 0.0;

  // Whether every stretch keeps within `share` of the median.
  [[nodiscard]] bool Within(double share) const {
    return std::max(current_A.most - median_A, median_A - current_A.least) <=
           share * std::abs(median_A);
  }
};

Level FindLevel(const Record& record, std::size_t first, std::size_t last, std::size_t rows) {
  constexpr std::size_t kBins = 4096;
  // Without the one row that moves no charge every row is a stretch.
  const std::size_t from = RowDuration(record, first) > 0.0 ? first : first + 1;
  const std::size_t end = RowDuration(record, last) > 0.0 ? last + 1 : last;
  if (from >= end)
    return {{record.current_A[last], record.current_A[last]}, record.current_A[last]};
  Level level;
  if (rows == 1) {
    level.current_A = FindExtent(std::span(record.current_A).subspan(from, end - from));
  } else {
    ForEachStretch(record, first, last, rows, [&](const Stretch& s) {
      level.current_A.least = std::min(level.current_A.least, s.current_A);
      level.current_A.most = std::max(level.current_A.most, s.current_A);
    });
  }
  const double lo = level.current_A.least;
  const double hi = level.current_A.most;
  level.median_A = lo;
  if (!(hi > lo)) return level;
  std::vector<Stretch> bins(kBins);  // in each the charge, for now, and the time
  double total_s = 0.0;
  ForEachStretch(record, first, last, rows, [&](const Stretch& s) {
    const double share = (s.current_A - lo) / (hi - lo);
    Stretch& bin = bins[std::min(static_cast<std::size_t>(share * kBins), kBins - 1)];
    bin.current_A += s.current_A * s.duration_s;
    bin.duration_s += s.duration_s;
    total_s += s.duration_s;
  });
  level.median_A = hi;
  double before_s = 0.0;
  for (const Stretch& bin : bins) {
    before_s += bin.duration_s;
    if (before_s < 0.5 * total_s) continue;
    level.median_A = bin.current_A / bin.duration_s;
    break;
  }
  return level;
}

}  // namespace

double RowNoise(std::span<const double> values, std::size_t first, std::size_t last) {
  // The quantile that sees a coarse instrument's last digit, and what it is for normal noise of
  // deviation 1 (by simulation: 1.555).
  constexpr double kQuantile = 0.9;
  constexpr double kOfNormalNoise = 1.555;
  constexpr std::size_t kSamples = 1 << 16;
  if (last < first + 2) return 0.0;
  const std::size_t stride = (last - first) / kSamples + 1;
  std::vector<double> distances;
  distances.reserve((last - first) / stride + 1);
  for (std::size_t k = first + 1; k < last; k += stride) {
    const double a = values[k - 1];
    const double b = values[k + 1];
    distances.push_back(
        std::abs(values[k] - std::clamp(values[k], std::min(a, b), std::max(a, b))));
  }
  const auto place =
      static_cast<std::size_t>(kQuantile * static_cast<double>(distances.size() - 1));
  return ValueAtPlace(distances, place) / kOfNormalNoise;
}

Constancy MeasureConstancy(const Record& record, std::size_t first, std::size_t last) {
  Require(first <= last && last < record.size(),
          "first <= last < size",
          {{"first", static_cast<double>(first)}, {"last", static_cast<double>(last)}});
  constexpr double kVisibleNoise =
      kOffMedian / 4.0;               // four deviations fit into the distance that counts
  constexpr double kMostNoise = 0.5;  // more is no noise but a drive
  Level level = FindLevel(record, first, last, 1);
  if (level.Within(kOffMedian)) return {.median_A = level.median_A};
  const double noise = RowNoise(record.current_A, first, last) / std::abs(level.median_A);
  std::size_t rows = 1;
  if (noise > kVisibleNoise && noise <= kMostNoise) {
    rows = static_cast<std::size_t>(std::ceil(std::pow(noise / kVisibleNoise, 2)));
    level = FindLevel(record, first, last, rows);
  }
  Constancy result{.median_A = level.median_A};
  double off_C = 0.0;
  double all_C = 0.0;
  ForEachStretch(record, first, last, rows, [&](const Stretch& s) {
    const double charge_C = std::abs(s.current_A) * s.duration_s;
    all_C += charge_C;
    const bool off =
        std::abs(s.current_A - result.median_A) > kOffMedian * std::abs(result.median_A);
    if (off) off_C += charge_C;
  });
  if (all_C > 0.0) result.charge_off_median = off_C / all_C;
  return result;
}

}  // namespace lipoid
