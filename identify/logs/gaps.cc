#include "identify/logs/gaps.h"

#include <algorithm>
#include <array>
#include <cstddef>

namespace lipoid {
namespace {

constexpr double kLonger = 10.0;
constexpr std::size_t kNeighbours = 5;

// Median of the up to kNeighbours intervals that end at rows first .. last; 0 where there are none.
double MedianInterval(const std::vector<double>& time_s, std::size_t first, std::size_t last) {
  std::array<double, kNeighbours> intervals{};
  std::size_t count = 0;
  for (std::size_t k = first; k <= last && k < time_s.size() && count < kNeighbours; ++k) {
    intervals[count++] = time_s[k] - time_s[k - 1];
  }
  if (count == 0) return 0.0;
  const auto middle = intervals.begin() + static_cast<std::ptrdiff_t>(count / 2);
  std::nth_element(
      intervals.begin(), middle, intervals.begin() + static_cast<std::ptrdiff_t>(count));
  return *middle;
}

}  // namespace

std::vector<Gap> FindGaps(const std::vector<double>& time_s) {
  std::vector<Gap> gaps;
  for (std::size_t k = 2; k < time_s.size(); ++k) {
    const double length_s = time_s[k] - time_s[k - 1];
    if (length_s <= kLonger * (time_s[k - 1] - time_s[k - 2])) continue;  // most rows end here
    const double before_s = MedianInterval(time_s, k > kNeighbours ? k - kNeighbours : 1, k - 1);
    const double after_s = MedianInterval(time_s, k + 1, k + kNeighbours);
    if (length_s > kLonger * std::max(before_s, after_s)) {
      gaps.push_back({.row = k, .start_s = time_s[k - 1], .length_s = length_s});
    }
  }
  return gaps;
}

}  // namespace lipoid
