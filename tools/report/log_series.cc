#include "tools/report/log_series.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <numeric>

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
                 std::size_t most_rows,
                 const Surroundings& surroundings,
                 RowsOverCharge* over_charge) {
  std::vector<std::vector<double>> predicted_V(cells.size(), std::vector<double>(record.size()));
  const bool measured = !record.voltage_V.empty();
  std::vector<std::vector<double>> error_V(measured ? cells.size() : 0);
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t c) {
    std::vector<double>& volts = predicted_V[c];
    const auto predict = [&](auto&& visit) {
      PredictRows(*cells[c].cell,
                  record.time_s,
                  record.current_A,
                  record.hold,
                  initial_soc,
                  surroundings,
                  visit);
    };
    if (c == 0 && over_charge != nullptr) {
      std::size_t next = 0;
      predict([&](std::size_t k, const PredictedRow& row) {
        volts[k] = row.voltage_V;
        if (next == over_charge->rows.size() || over_charge->rows[next] != k) return;
        ++next;
        over_charge->soc.push_back(row.soc);
        over_charge->predicted_V.push_back(row.voltage_V);
      });
    } else {
      predict([&](std::size_t k, const PredictedRow& row) { volts[k] = row.voltage_V; });
    }
    if (!measured) return;
    error_V[c].resize(record.size());
    for (std::size_t k = 0; k < record.size(); ++k) error_V[c][k] = record.voltage_V[k] - volts[k];
  });
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
