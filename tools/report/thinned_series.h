#pragma once

/// @file
/// Series of a page with so few rows that the page stays small, without losing a peak. Tests:
/// tests/tools/flight_series_test.cc, tests/tools/report_page_test.cc.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "tools/report/report.h"

namespace lipoid {

/// Of each stretch of so many rows the first row, and those at which a column is least or largest;
/// and the last row of all. `index` says which row of the whole each is. NaN is neither.
template <class Column>
std::vector<std::size_t> ExtremeRows(const std::vector<std::size_t>& index,
                                     const std::vector<Column>& columns,
                                     std::size_t stretch) {
  std::vector<std::size_t> kept;
  for (std::size_t first = 0; first < index.size();) {
    std::size_t last = first + 1;
    while (last < index.size() && index[last] / stretch == index[first] / stretch) ++last;
    const auto begin = static_cast<std::ptrdiff_t>(kept.size());
    kept.push_back(first);
    if (last == index.size()) kept.push_back(last - 1);
    for (const Column& column : columns) {
      std::size_t least = first;
      std::size_t largest = first;
      for (std::size_t row = first + 1; row < last; ++row) {
        if (column[row] < column[least]) least = row;
        if (column[row] > column[largest]) largest = row;
      }
      kept.push_back(least);
      kept.push_back(largest);
    }
    std::sort(kept.begin() + begin, kept.end());
    kept.erase(std::unique(kept.begin() + begin, kept.end()), kept.end());
    first = last;
  }
  return kept;
}

/// Whether all values are the same; NaN is the same as NaN. Not so of none.
[[nodiscard]] bool IsConstant(const std::vector<double>& values);

/// What the samples of a series take in a page: base64, and nothing for columns that repeat another
/// or one value throughout.
[[nodiscard]] std::size_t BytesOf(const Series& series);

/// The series with so few rows that it takes no more than `most_bytes` of a page: stretches of equal
/// length keep the rows at which a column is least or largest.
[[nodiscard]] Series Thinned(const Series& series, std::size_t most_bytes);

/// `total` divided among those who want so much each: who wants less than an equal share gets all
/// that it wants, and what it leaves goes to the others. No share is below `least`, as far as it is
/// wanted, even where the sum is then above the total.
[[nodiscard]] std::vector<std::size_t> Shares(std::span<const std::size_t> wanted,
                                              std::size_t total,
                                              std::size_t least = 0);

}  // namespace lipoid
