#pragma once

/// @file
/// Fewer rows that look the same: each stretch of rows keeps those at which a column is least and
/// largest, as the pixels of a chart would show them, so that no peak is lost; and all rows about
/// the greatest jumps of one column (the edges of a current), where people zoom in. Tests:
/// tests/tools/report_page_test.cc.

#include <cstddef>
#include <span>
#include <vector>

namespace lipoid {

/// Indices of the rows that stay, increasing: at most `most` of them, the first and the last
/// included; all where there are no more. At least half of them may lie about the jumps of `jumps`, and
/// what single extremes of several columns leave does. Columns are as long as `rows`; NaN is passed over.
[[nodiscard]] std::vector<std::size_t> ThinnedRows(std::size_t rows,
                                                   std::span<const std::span<const double>> columns,
                                                   std::span<const double> jumps,
                                                   std::size_t most);

/// The values at those rows.
[[nodiscard]] std::vector<double> At(std::span<const double> values,
                                     std::span<const std::size_t> rows);

}  // namespace lipoid
