#include "tools/report/flight_series.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>

#include "tools/report/thin.h"

namespace lipoid {
namespace {

// Rows in memory: 7 MB.
constexpr std::size_t kMostRows = std::size_t{1} << 16;

// In base64 three bytes take four.
constexpr double kBytesOfBase64 = 4.0 / 3.0;

std::vector<std::string> LogColumns(std::size_t rotors) {
  std::vector<std::string> names;
  FlightSample::OfRotors(rotors).Visit([&](const char* name, double) { names.emplace_back(name); });
  return names;
}

// Time apart, which has a type of its own.
bool Shown(const std::string& name) {
  return name != "time_s" && !name.starts_with("velocity_") && !name.starts_with("climb_") &&
         !name.ends_with("_rate_rad_per_s") && !name.starts_with("current_");
}

// Of each stretch of so many rows of the flight the first row, and those at which a column is least
// or largest; and the last row of all. `index` says which row of the flight each is.
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
        // A comparison with NaN is false: it is neither.
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

template <class Value>
void Keep(const std::vector<std::size_t>& rows, std::vector<Value>& column) {
  for (std::size_t to = 0; to < rows.size(); ++to) column[to] = column[rows[to]];
  column.resize(rows.size());
}

bool Same(double a, double b) { return a == b || (std::isnan(a) && std::isnan(b)); }

// Columns that repeat another, or one value throughout, take nothing (report.cc).
double BytesPerRow(const Series& series) {
  std::size_t bytes = 0;
  for (auto column = series.columns.begin(); column != series.columns.end(); ++column) {
    const auto& values = column->values;
    const bool constant = std::all_of(
        values.begin(), values.end(), [&](double value) { return Same(value, values[0]); });
    const bool repeated = std::any_of(series.columns.begin(), column, [&](const auto& earlier) {
      return std::equal(values.begin(), values.end(), earlier.values.begin(), &Same);
    });
    if (!constant && !repeated) bytes += column->name == "time_s" ? sizeof(double) : sizeof(float);
  }
  return kBytesOfBase64 * static_cast<double>(std::max<std::size_t>(bytes, 1));
}

}  // namespace

FlightSeries::FlightSeries(std::size_t rotors) : names_(LogColumns(rotors)) {
  for (std::size_t k = 0; k < names_.size(); ++k) {
    if (Shown(names_[k])) shown_.push_back(k);
  }
  values_.resize(shown_.size());
}

void FlightSeries::Row(const FlightSample& sample) {
  if (index_.size() == kMostRows) {
    while (index_.size() > kMostRows / 2) KeepExtremes(stretch_ *= 2);
  }
  index_.push_back(seen_++);
  time_s_.push_back(sample.time_s);
  std::size_t column = 0;
  std::size_t next = 0;
  sample.Visit([&](const char*, double value) {
    if (next == shown_.size() || shown_[next] != column++) return;
    values_[next++].push_back(static_cast<float>(value));
  });
}

void FlightSeries::KeepExtremes(std::size_t stretch) {
  const auto rows = ExtremeRows(index_, values_, stretch);
  Keep(rows, index_);
  Keep(rows, time_s_);
  for (auto& column : values_) Keep(rows, column);
}

Series FlightSeries::Take(const std::string& name) {
  // The rows that came last are as thin as those before them.
  if (stretch_ > 1) KeepExtremes(stretch_);
  Series series{"flight", name, seen_, {}};
  series.columns.push_back({"time_s", std::move(time_s_)});
  for (std::size_t k = 0; k < shown_.size(); ++k) {
    const auto& values = values_[k];
    series.columns.push_back({names_[shown_[k]], {values.begin(), values.end()}});
  }
  return series;
}

Series Thinned(const Series& series, std::size_t most_bytes) {
  const std::size_t rows = series.columns.empty() ? 0 : series.columns[0].values.size();
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
  Series thinned{series.kind, series.name, series.rows, {}};
  for (const auto& [name, values] : series.columns)
    thinned.columns.push_back({name, At(values, kept)});
  return thinned;
}

}  // namespace lipoid
