#include "tools/report/thinned_series.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "tools/report/thin.h"

namespace lipoid {
namespace {

// In base64 three bytes take four.
constexpr double kBytesOfBase64 = 4.0 / 3.0;

bool Same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

// Columns that repeat another, or one value throughout, take nothing (report.cc).
double BytesPerRow(const Series& series) {
  std::size_t bytes = 0;
  for (auto column = series.columns.begin(); column != series.columns.end(); ++column) {
    const auto& values = column->values;
    const bool repeated = std::any_of(series.columns.begin(), column, [&](const auto& earlier) {
      return std::equal(values.begin(), values.end(), earlier.values.begin(), &Same);
    });
    if (!IsConstant(values) && !repeated)
      bytes += column->name == "time_s" ? sizeof(double) : sizeof(float);
  }
  return kBytesOfBase64 * static_cast<double>(std::max<std::size_t>(bytes, 1));
}

std::size_t RowsOf(const Series& series) {
  return series.columns.empty() ? 0 : series.columns[0].values.size();
}

}  // namespace

bool IsConstant(const std::vector<double>& values) {
  return !values.empty() && std::all_of(values.begin(), values.end(), [&](double value) {
    return Same(value, values[0]);
  });
}

std::size_t BytesOf(const Series& series) {
  return static_cast<std::size_t>(
      std::ceil(BytesPerRow(series) * static_cast<double>(RowsOf(series))));
}

Series Thinned(const Series& series, std::size_t most_bytes) {
  const std::size_t rows = RowsOf(series);
  const double most_rows = static_cast<double>(most_bytes) / BytesPerRow(series);
  if (static_cast<double>(rows) <= most_rows) return series;
  std::vector<std::size_t> kept(rows);
  for (std::size_t k = 0; k < rows; ++k) kept[k] = k;
  const std::vector<std::size_t> all = kept;
  std::vector<std::span<const double>> columns;
  for (const auto& column : series.columns) {
    if (column.name != "time_s") columns.emplace_back(column.values);
  }
  // One stretch that holds them all keeps two rows of each column, the least there can be.
  for (std::size_t stretch = 4; static_cast<double>(kept.size()) > most_rows && stretch / 2 < rows;
       stretch += stretch / 4)
    kept = ExtremeRows(all, columns, stretch);
  Series thinned{series.kind, series.name, series.rows, series.of, {}};
  for (const auto& [name, values] : series.columns)
    thinned.columns.push_back({name, At(values, kept)});
  return thinned;
}

std::vector<std::size_t> Shares(std::span<const std::size_t> wanted,
                                std::size_t total,
                                std::size_t least) {
  std::vector<std::size_t> order(wanted.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return wanted[a] < wanted[b];
  });
  std::vector<std::size_t> shares(wanted.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const std::size_t share = std::max(least, total / (order.size() - n));
    shares[order[n]] = std::min(wanted[order[n]], share);
    total -= std::min(total, shares[order[n]]);
  }
  return shares;
}

}  // namespace lipoid
