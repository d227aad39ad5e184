#include "tools/report/log_series.h"

#include <array>
#include <nlohmann/json.hpp>

#include "tools/report/thin.h"

namespace lipoid {

Series LogSeries(const Cell& cell,
                 const Record& record,
                 const std::string& name,
                 double initial_soc,
                 std::size_t most_rows,
                 const Surroundings& surroundings) {
  std::vector<double> predicted_V(record.size());
  PredictRows(cell,
              record.time_s,
              record.current_A,
              record.hold,
              initial_soc,
              surroundings,
              [&](std::size_t k, const PredictedRow& row) { predicted_V[k] = row.voltage_V; });
  const std::array<std::span<const double>, 3> seen = {
      record.current_A, record.voltage_V, predicted_V};
  const auto rows = ThinnedRows(record.size(), seen, record.current_A, most_rows);
  Series series{"log", name, record.size(), {}};
  const auto add = [&](const char* column, std::span<const double> values) {
    series.columns.push_back({column, At(values, rows)});
  };
  add("time_s", record.time_s);
  add("current_A", record.current_A);
  add("voltage_V", record.voltage_V);
  add("predicted_V", predicted_V);
  if (!record.temperature_degC.empty()) add("temperature_degC", record.temperature_degC);
  return series;
}

}  // namespace lipoid
