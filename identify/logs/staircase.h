#pragma once

/// @file
/// A slow quantity behind a sensor of coarse steps, above all a temperature in whole degrees: between
/// two steps it moved, although every row shows the same. Tests:
/// tests/identify/logs/staircase_test.cc.

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace lipoid {

/// The least that the shown value ever changes by; infinite where it does not.
[[nodiscard]] inline double StepOf(std::span<const double> shown) {
  double step = std::numeric_limits<double>::infinity();
  for (std::size_t k = 1; k < shown.size(); ++k) {
    if (shown[k] != shown[k - 1]) step = std::min(step, std::abs(shown[k] - shown[k - 1]));
  }
  return step;
}

/// Rows, from the first to the last.
using RowStretch = std::pair<std::size_t, std::size_t>;

/// Calls act(stretch) for the stretches of rows that show one value, which one after another are all rows. Rows may be means, and that of equal values is the value up to rounding.
template <class Act>
void ForEachStretchOfOneValue(std::span<const double> shown, const Act& act) {
  constexpr double kRounding = 1e-9;
  for (std::size_t first = 0; first < shown.size();) {
    std::size_t last = first;
    while (last + 1 < shown.size() &&
           std::abs(shown[last + 1] - shown[first]) <= kRounding * std::abs(shown[first]))
      ++last;
    act(RowStretch(first, last));
    first = last + 1;
  }
}

/// The values without their steps, as many as there are, and nowhere further than half a step from what the sensor shows. Where it
/// goes from one step to the next, the quantity was between the two; from there to the next such place it is taken to go straight, and
/// over what the sensor shows in the middle where it turns back. Larger jumps stay.
[[nodiscard]] inline std::vector<double> WithoutSteps(std::span<const double> time_s,
                                                      std::span<const double> shown) {
  std::vector<double> smooth(shown.begin(), shown.end());
  const double step = StepOf(shown);
  // What the quantity was at the two ends of a plateau, the rows from first to last, which show one value.
  const auto fill = [&](std::size_t first, std::size_t last, double from, double to) {
    const double middle = shown[first];
    const bool turns = (from - middle) * (to - middle) > 0.0;
    const double begin_s = first > 0 ? 0.5 * (time_s[first - 1] + time_s[first]) : time_s[first];
    const double end_s =
        last + 1 < time_s.size() ? 0.5 * (time_s[last] + time_s[last + 1]) : time_s[last];
    if (!(end_s > begin_s)) return;
    for (std::size_t k = first; k <= last; ++k) {
      const double share = (time_s[k] - begin_s) / (end_s - begin_s);
      if (!turns) {
        smooth[k] = std::lerp(from, to, share);
      } else {
        smooth[k] = share < 0.5 ? std::lerp(from, middle, 2.0 * share)
                                : std::lerp(middle, to, 2.0 * share - 1.0);
      }
    }
  };
  // What the quantity was between the row at an end of a plateau and the next one beyond it.
  const auto between = [&](std::size_t row, std::size_t next) {
    const double rise = shown[next] - shown[row];
    return std::abs(rise) < 1.5 * step ? shown[row] + 0.5 * rise : shown[row];
  };
  for (std::size_t first = 0; first < shown.size();) {
    std::size_t last = first;
    while (last + 1 < shown.size() && shown[last + 1] == shown[first]) ++last;
    const double from = first > 0 ? between(first, first - 1) : shown[first];
    const double to = last + 1 < shown.size() ? between(last, last + 1) : shown[last];
    fill(first, last, from, to);
    first = last + 1;
  }
  return smooth;
}

}  // namespace lipoid
