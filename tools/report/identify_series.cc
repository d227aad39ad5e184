#include "tools/report/identify_series.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <functional>
#include <nlohmann/json.hpp>

#include "identify/logs/segments.h"
#include "identify/validation.h"
#include "tools/report/log_series.h"
#include "tools/report/thin.h"

namespace lipoid {
namespace {

constexpr std::size_t kRowsOfCurve = 1500;  // more than a chart has pixels

// Voltages over the state of charge, at some rows of a record.
Series OverCharge(const std::string& kind,
                  const OpenCircuitVoltage& curve,
                  const LoadedLog& log,
                  const RowsOverCharge& at) {
  std::vector<double> measured_V = At(log.log.record.voltage_V, at.rows);
  std::vector<double> open_circuit_V;
  for (std::size_t k = 0; k < at.rows.size(); ++k)
    open_circuit_V.push_back(measured_V[k] - at.predicted_V[k] + curve(at.soc[k]));
  Series series{.kind = kind, .name = log.entry.file, .rows = at.rows.size()};
  series.columns = {{"soc", at.soc},
                    {"voltage_V", std::move(measured_V)},
                    {"open_circuit_V", std::move(open_circuit_V)}};
  return series;
}

// A current that passes through zero is no rest.
std::vector<std::size_t> EndsOfRests(const Record& record) {
  constexpr double kLeast_s = 10.0;
  std::vector<std::size_t> rows;
  for (const Segment& segment : FindSegments(record)) {
    if (segment.kind == SegmentKind::kRest && segment.duration_s() >= kLeast_s)
      rows.push_back(segment.last);
  }
  if (rows.size() <= kRowsOfCurve) return rows;
  std::vector<std::size_t> some;
  for (std::size_t n = 0; n < kRowsOfCurve; ++n)
    some.push_back(rows[n * rows.size() / kRowsOfCurve]);
  return some;
}

// Calls act(0), act(1), ..., each begun as soon as a core is free: what lasts long stands first.
void ParallelInOrder(std::size_t count, const std::function<void(std::size_t)>& act) {
  std::atomic<std::size_t> next = 0;
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t) { act(next++); });
}

Series CurveSeries(const OpenCircuitVoltage& curve) {
  constexpr int kSteps = 400;
  std::vector<double> socs;
  std::vector<double> volts;
  for (int n = 0; n <= kSteps; ++n) {
    const double soc = curve.soc_lo() + (curve.soc_hi() - curve.soc_lo()) * n / kSteps;
    socs.push_back(soc);
    volts.push_back(curve(soc));
  }
  Series series{.kind = "staged-curve", .name = "staged", .rows = socs.size()};
  series.columns = {{"soc", std::move(socs)}, {"voltage_V", std::move(volts)}};
  return series;
}

}  // namespace

std::vector<Series> IdentifySeries(const Cell& found,
                                   const Cell* staged,
                                   const std::vector<LoadedLog>& logs,
                                   std::size_t n,
                                   std::size_t campaigns) {
  const Cell cell = found.AsOne();  // the records are those of one cell
  Cell other;
  std::vector<PredictedColumn> cells{{"predicted_V", &cell}};
  if (staged != nullptr) {
    other = staged->AsOne();
    cells.push_back({"staged_V", &other});
  }
  std::vector<std::size_t> rows;
  for (const LoadedLog& log : logs) rows.push_back(log.log.record.size());
  // Current and voltage, the predictions, and the temperature that some logs have.
  constexpr std::size_t kMeasured = 3;
  const auto most = RowsOfPage(rows, campaigns * (kMeasured + cells.size()));

  const std::size_t count = logs.size();
  std::vector<RowsOverCharge> at(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t n_log) {
    const Record& record = logs[n_log].log.record;
    const LogKind kind = logs[n_log].entry.kind;
    if (kind == LogKind::kLowRate) {
      const std::array<std::span<const double>, 1> seen{record.voltage_V};
      at[n_log].rows = ThinnedRows(record.size(), seen, {}, kRowsOfCurve);
    } else if (TakesPartInLabFit(kind) && kind != LogKind::kConstantCurrent) {
      at[n_log].rows = EndsOfRests(record);
    }
  });
  // Each cell along each log, the longest first: one log may have most of the rows of all.
  std::vector<std::vector<ColumnOfPage>> of_cells(count);
  for (auto& each : of_cells) each.resize(cells.size());
  std::vector<std::pair<std::size_t, std::size_t>> work;  // log, cell
  for (std::size_t n_log = 0; n_log < count; ++n_log) {
    for (std::size_t c = 0; c < cells.size(); ++c) work.emplace_back(n_log, c);
  }
  std::stable_sort(work.begin(), work.end(), [&](const auto& a, const auto& b) {
    return rows[a.first] > rows[b.first];
  });
  ParallelInOrder(work.size(), [&](std::size_t k) {
    const auto [n_log, c] = work[k];
    const LoadedLog& log = logs[n_log];
    of_cells[n_log][c] = ThinnedBy(*cells[c].cell,
                                   log.log.record,
                                   log.entry.initial_soc,
                                   SurroundingsOf(log.log.record, log.entry),
                                   c == 0 ? &at[n_log] : nullptr);
  });
  std::vector<Series> of_logs(count);
  std::vector<Series> of_charge(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t n_log) {
    const LoadedLog& log = logs[n_log];
    of_logs[n_log] = LogSeries(cells, log.log.record, log.entry.file, most[n_log], of_cells[n_log]);
    of_cells[n_log].clear();
    of_charge[n_log] = OverCharge(log.entry.kind == LogKind::kLowRate ? "low-rate" : "rests",
                                  cell.open_circuit_voltage,
                                  log,
                                  at[n_log]);
  });
  std::vector<Series> series = std::move(of_logs);
  for (Series& each : of_charge) {
    if (each.rows > 0) series.push_back(std::move(each));
  }
  if (staged != nullptr) series.push_back(CurveSeries(other.open_circuit_voltage));
  for (Series& each : series) each.of = n;
  return series;
}

}  // namespace lipoid
