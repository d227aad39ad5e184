#pragma once

/// @file
/// The interval that holds 95 % of what a sample was drawn from.
/// Tests: tests/model/statistics/interval_95_test.cc.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "model/core/special_values.h"

namespace lipoid {

/// With fewer values the interval is that from the least to the greatest.
inline constexpr std::size_t kLeastForQuantiles = 39;

/// What is to be said of an interval of so many `things` (cells, flights), one sentence; empty where
/// they are enough.
[[nodiscard]] inline std::string DoubtAboutFew(std::size_t count, std::string_view things) {
  if (count == 0 || count >= kLeastForQuantiles) return "";
  return fmt::format(
      "of {} {} the interval is that from the lowest to the highest, which may leave out the "
      "estimate: quantiles take {}",
      count,
      things,
      kLeastForQuantiles);
}

/// The quantiles at 2.5 % and 97.5 %: of n values the one at place p (n + 1), with a straight line
/// between two, because of n + 1 values from one distribution each is as likely the k-th. Changes
/// the order of the values. NaN where there are none.
[[nodiscard]] inline std::pair<double, double> Interval95(std::span<double> values) {
  const auto n = static_cast<std::ptrdiff_t>(values.size());
  if (n == 0) return {kNaN, kNaN};
  constexpr double kTail = 0.025;
  const double place = std::max(0.0, kTail * static_cast<double>(n + 1) - 1.0);
  const auto whole = static_cast<std::ptrdiff_t>(place);
  const double share = place - static_cast<double>(whole);
  const auto between = [&](auto begin, auto end, auto before) {
    const auto at = begin + whole;
    std::nth_element(begin, at, end, before);
    const double first = *at;
    if (share == 0.0 || at + 1 == end) return first;
    return first + share * (*std::min_element(at + 1, end, before) - first);
  };
  const double low = between(values.begin(), values.end(), std::less<>());
  const double high = between(values.begin(), values.end(), std::greater<>());
  return {low, high};
}

}  // namespace lipoid
