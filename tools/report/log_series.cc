#include "tools/report/log_series.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

#include "model/battery/prediction.h"
#include "tools/report/thin.h"

namespace lipoid {
namespace {

// Of all samples of a page, before base64 makes four bytes of three.
constexpr std::size_t kBytesOfPage = 1'100'000;
constexpr std::size_t kBytesOfTime = 8;
constexpr std::size_t kBytesOfValue = 4;
// A log of which less is kept has no picture: many short logs may make a larger page.
constexpr std::size_t kLeastRows = 200;

}  // namespace

std::vector<std::size_t> RowsOfPage(std::span<const std::size_t> rows, std::size_t columns) {
  std::vector<std::size_t> order(rows.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(
      order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return rows[a] < rows[b]; });
  std::size_t left = kBytesOfPage / (kBytesOfTime + kBytesOfValue * columns);
  std::vector<std::size_t> kept(rows.size());
  for (std::size_t n = 0; n < order.size(); ++n) {
    const std::size_t share = std::max(kLeastRows, left / (order.size() - n));
    kept[order[n]] = std::min(rows[order[n]], share);
    left -= std::min(left, kept[order[n]]);
  }
  return kept;
}

Series LogSeries(std::span<const PredictedColumn> cells,
                 const Record& record,
                 const std::string& name,
                 double initial_soc,
                 std::size_t most_rows) {
  std::vector<std::vector<double>> predicted_V(cells.size(), std::vector<double>(record.size()));
  std::vector<std::vector<double>> error_V;
  for (std::size_t c = 0; c < cells.size(); ++c) {
    std::vector<double>& volts = predicted_V[c];
    PredictRows(*cells[c].cell,
                record.time_s,
                record.current_A,
                record.hold,
                initial_soc,
                [&](std::size_t k, double, double voltage_V) { volts[k] = voltage_V; });
    if (record.voltage_V.empty()) continue;
    error_V.emplace_back(record.size());
    std::transform(volts.begin(),
                   volts.end(),
                   record.voltage_V.begin(),
                   error_V.back().begin(),
                   [](double predicted, double measured) { return measured - predicted; });
  }
  std::vector<std::span<const double>> seen{record.current_A};
  if (!record.voltage_V.empty()) seen.emplace_back(record.voltage_V);
  seen.insert(seen.end(), error_V.begin(), error_V.end());
  const auto rows = ThinnedRows(record.size(), seen, record.current_A, most_rows);
  Series series{.kind = "log", .name = name, .rows = record.size()};
  const auto add = [&](const std::string& column, std::span<const double> values) {
    if (!values.empty()) series.columns.push_back({column, At(values, rows)});
  };
  add("time_s", record.time_s);
  add("current_A", record.current_A);
  add("voltage_V", record.voltage_V);
  for (std::size_t c = 0; c < cells.size(); ++c) add(cells[c].name, predicted_V[c]);
  add("temperature_degC", record.temperature_degC);
  return series;
}

}  // namespace lipoid
