#include "tools/report/log_series.h"

#include <tbb/parallel_for.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tools/report/thin.h"
#include "tools/report/thinned_series.h"

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
  return Shares(rows, kBytesOfPage / (kBytesOfTime + kBytesOfValue * columns), kLeastRows);
}

ColumnOfPage ThinnedBy(const Cell& cell,
                       const Record& record,
                       double initial_soc,
                       const Surroundings& surroundings,
                       RowsOverCharge* over_charge) {
  const bool measured = !record.voltage_V.empty();
  ColumnOfPage column = std::make_unique_for_overwrite<double[]>(record.size());
  double* const values = column.get();
  const double* const measured_V = record.voltage_V.data();
  const auto predict = [&](auto&& visit) {
    PredictRows(cell,
                record.time_s,
                record.current_A,
                record.hold,
                initial_soc,
                surroundings,
                [&](std::size_t k, const PredictedRow& row) {
                  values[k] = measured ? measured_V[k] - row.voltage_V : row.voltage_V;
                  visit(k, row);
                });
  };
  if (over_charge == nullptr) {
    predict([](std::size_t, const PredictedRow&) {});
    return column;
  }
  std::size_t next = 0;
  predict([&](std::size_t k, const PredictedRow& row) {
    if (next == over_charge->rows.size() || over_charge->rows[next] != k) return;
    ++next;
    over_charge->soc.push_back(row.soc);
    over_charge->predicted_V.push_back(row.voltage_V);
  });
  return column;
}

Series LogSeries(std::span<const PredictedColumn> cells,
                 const Record& record,
                 const std::string& name,
                 double initial_soc,
                 std::size_t most_rows,
                 const Surroundings& surroundings) {
  std::vector<ColumnOfPage> of_cell(cells.size());
  tbb::parallel_for(std::size_t{0}, cells.size(), [&](std::size_t c) {
    of_cell[c] = ThinnedBy(*cells[c].cell, record, initial_soc, surroundings);
  });
  return LogSeries(cells, record, name, most_rows, of_cell);
}

Series LogSeries(std::span<const PredictedColumn> cells,
                 const Record& record,
                 const std::string& name,
                 std::size_t most_rows,
                 std::span<const ColumnOfPage> of_cell) {
  const bool measured = !record.voltage_V.empty();
  std::vector<std::span<const double>> seen{record.current_A};
  if (measured) {
    seen.emplace_back(record.voltage_V);
    for (const auto& values : of_cell) seen.emplace_back(values.get(), record.size());
  }
  const auto rows = ThinnedRows(record.size(), seen, record.current_A, most_rows);
  Series series{.kind = "log", .name = name, .rows = record.size()};
  const auto add = [&](const std::string& column, std::span<const double> values) {
    if (!values.empty()) series.columns.push_back({column, At(values, rows)});
  };
  add("time_s", record.time_s);
  add("current_A", record.current_A);
  add("voltage_V", record.voltage_V);
  for (std::size_t c = 0; c < cells.size(); ++c) {
    std::vector<double> predicted_V = At({of_cell[c].get(), record.size()}, rows);
    for (std::size_t n = 0; measured && n < rows.size(); ++n)
      predicted_V[n] = record.voltage_V[rows[n]] - predicted_V[n];
    if (!rows.empty()) series.columns.push_back({cells[c].name, std::move(predicted_V)});
  }
  add("temperature_degC", record.temperature_degC);
  return series;
}

}  // namespace lipoid
