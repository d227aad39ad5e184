#include "tools/report/thin.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace lipoid {
namespace {

// Rows about a jump that stay, at least and at most: a pulse's first instants. One of eight lies
// before the jump.
constexpr std::size_t kLeastAbout = 64;
constexpr std::size_t kMostAbout = 4096;
constexpr std::size_t kBefore = 8;

// A jump is what is larger than this share of the largest one.
constexpr double kJumpShare = 0.05;

void KeepExtremes(std::span<const double> column,
                  std::size_t first,
                  std::size_t last,
                  std::vector<std::size_t>& kept) {
  // NaN is neither less nor more than anything.
  double low = std::numeric_limits<double>::infinity();
  double high = -low;
  std::size_t least = last;
  std::size_t largest = last;
  for (std::size_t k = first; k < last; ++k) {
    const double value = column[k];
    if (value < low) {
      low = value;
      least = k;
    }
    if (value > high) {
      high = value;
      largest = k;
    }
  }
  if (least < last) kept.push_back(least);
  if (largest < last) kept.push_back(largest);
}

void SortedOnce(std::vector<std::size_t>& rows) {
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
}

// The rows at which a column jumps, with how far.
std::vector<std::pair<double, std::size_t>> JumpsOf(std::span<const double> column) {
  std::vector<std::pair<double, std::size_t>> jumps;
  double largest = 0.0;
  for (std::size_t k = 1; k < column.size(); ++k)
    largest = std::max(largest, std::abs(column[k] - column[k - 1]));
  if (!(largest > 0.0)) return jumps;
  for (std::size_t k = 1; k < column.size(); ++k) {
    const double jump = std::abs(column[k] - column[k - 1]);
    if (jump >= kJumpShare * largest) jumps.emplace_back(jump, k);
  }
  return jumps;
}

// The rows about the largest of these jumps of a log of so many rows, at most `most` of them.
void KeepJumps(std::vector<std::pair<double, std::size_t>> jumps,
               std::size_t rows,
               std::size_t most,
               std::vector<std::size_t>& kept) {
  const std::size_t places = std::min(jumps.size(), most / kLeastAbout);
  if (places == 0) return;
  if (places < jumps.size()) {
    // The largest; of equal ones those that lie evenly over the log.
    const std::size_t stride = (jumps.size() + places - 1) / places;
    std::vector<std::pair<double, std::size_t>> spread;
    for (std::size_t k = 0; k < jumps.size(); k += stride) {
      const auto end =
          jumps.begin() + static_cast<std::ptrdiff_t>(std::min(k + stride, jumps.size()));
      spread.push_back(*std::max_element(jumps.begin() + static_cast<std::ptrdiff_t>(k), end));
    }
    jumps = std::move(spread);
  }
  const std::size_t about = std::min(kMostAbout, most / jumps.size());
  for (const auto& jump : jumps) {
    const std::size_t first = jump.second - std::min(jump.second, about / kBefore);
    const std::size_t end = std::min(rows, first + about);
    for (std::size_t k = first; k < end; ++k) kept.push_back(k);
  }
}

}  // namespace

std::vector<std::size_t> ThinnedRows(std::size_t rows,
                                     std::span<const std::span<const double>> columns,
                                     std::span<const double> jumps,
                                     std::size_t most) {
  std::vector<std::size_t> kept;
  if (rows <= most) {
    kept.resize(rows);
    std::iota(kept.begin(), kept.end(), std::size_t{0});
    return kept;
  }
  kept = {0, rows - 1};
  const auto found = JumpsOf(jumps);
  const std::size_t left =
      most - std::min(most, 2 + std::min(most / 2, kLeastAbout * found.size()));
  const std::size_t stretches = left / (2 * std::max<std::size_t>(columns.size(), 1));
  std::vector<std::vector<std::size_t>> extremes(stretches);
  tbb::parallel_for(std::size_t{0}, stretches, [&](std::size_t n) {
    const std::size_t first = rows * n / stretches;
    const std::size_t last = rows * (n + 1) / stretches;
    for (const auto column : columns) KeepExtremes(column, first, last, extremes[n]);
  });
  for (const auto& each : extremes) kept.insert(kept.end(), each.begin(), each.end());
  SortedOnce(kept);
  // One row is often the extreme of several columns: what that leaves goes to the jumps.
  KeepJumps(found, rows, most - std::min(most, kept.size()), kept);
  SortedOnce(kept);
  return kept;
}

std::vector<double> At(std::span<const double> values, std::span<const std::size_t> rows) {
  std::vector<double> at;
  at.reserve(rows.size());
  for (const std::size_t row : rows) at.push_back(values[row]);
  return at;
}

}  // namespace lipoid
