#include "tools/report/identify_series.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "identify/logs/segments.h"
#include "model/battery/prediction.h"
#include "tools/report/log_series.h"
#include "tools/report/thin.h"

namespace lipoid {
namespace {

constexpr std::size_t kRowsOfCurve = 1500;  // more than a chart has pixels

// Voltages over the state of charge, at some rows of a record.
Series OverCharge(const std::string& kind,
                  const Cell& cell,
                  const LoadedLog& log,
                  const std::vector<std::size_t>& rows) {
  const Record& record = log.log.record;
  Series series{.kind = kind, .name = log.entry.file, .rows = rows.size()};
  std::vector<double> socs;
  std::vector<double> measured_V;
  std::vector<double> open_circuit_V;
  std::size_t next = 0;
  PredictRows(
      cell,
      record.time_s,
      record.current_A,
      record.hold,
      log.entry.initial_soc,
      [&](std::size_t k, double soc, double voltage_V) {
        if (next == rows.size() || rows[next] != k) return;
        ++next;
        socs.push_back(soc);
        measured_V.push_back(record.voltage_V[k]);
        open_circuit_V.push_back(record.voltage_V[k] - voltage_V + cell.open_circuit_voltage(soc));
      });
  series.columns = {{"soc", std::move(socs)},
                    {"voltage_V", std::move(measured_V)},
                    {"open_circuit_V", std::move(open_circuit_V)}};
  return series;
}

std::vector<std::size_t> EndsOfRests(const Record& record) {
  std::vector<std::size_t> rows;
  for (const Segment& segment : FindSegments(record)) {
    if (segment.kind == SegmentKind::kRest) rows.push_back(segment.last);
  }
  if (rows.size() <= kRowsOfCurve) return rows;
  std::vector<std::size_t> some;
  for (std::size_t n = 0; n < kRowsOfCurve; ++n)
    some.push_back(rows[n * rows.size() / kRowsOfCurve]);
  return some;
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

std::vector<Series> IdentifySeries(const Identification& found,
                                   const std::vector<LoadedLog>& logs,
                                   std::size_t n,
                                   std::size_t campaigns) {
  Cell cell = found.cell;  // the records are those of one cell
  cell.series = cell.parallel = 1;
  Cell staged;
  std::vector<PredictedColumn> cells{{"predicted_V", &cell}};
  if (found.joint) {
    staged = found.joint->staged.cell;
    staged.series = staged.parallel = 1;
    cells.push_back({"staged_V", &staged});
  }
  std::vector<std::size_t> rows;
  for (const LoadedLog& log : logs) rows.push_back(log.log.record.size());
  // Current and voltage, the predictions, and the temperature that some logs have.
  constexpr std::size_t kMeasured = 3;
  const auto most = RowsOfPage(rows, campaigns * (kMeasured + cells.size()));

  const std::size_t count = logs.size();
  std::vector<Series> of_logs(count);
  std::vector<Series> of_charge(count);
  tbb::parallel_for(std::size_t{0}, 2 * count, [&](std::size_t task) {
    const LoadedLog& log = logs[task / 2];
    const Record& record = log.log.record;
    if (task % 2 == 0) {
      of_logs[task / 2] =
          LogSeries(cells, record, log.entry.file, log.entry.initial_soc, most[task / 2]);
    } else if (log.entry.kind == LogKind::kLowRate) {
      const std::array<std::span<const double>, 1> seen{record.voltage_V};
      of_charge[task / 2] =
          OverCharge("low-rate", cell, log, ThinnedRows(record.size(), seen, {}, kRowsOfCurve));
    } else {
      of_charge[task / 2] = OverCharge("rests", cell, log, EndsOfRests(record));
    }
  });
  std::vector<Series> series = std::move(of_logs);
  for (Series& each : of_charge) {
    if (each.rows > 0) series.push_back(std::move(each));
  }
  if (found.joint) series.push_back(CurveSeries(staged.open_circuit_voltage));
  for (Series& each : series) each.of = n;
  return series;
}

}  // namespace lipoid
