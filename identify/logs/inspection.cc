#include "identify/logs/inspection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/logs/read_logs.h"

namespace lipoid {
namespace {

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  Spread spread{.least = *least, .largest = *largest};
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  spread.median = *middle;
  return spread;
}

}  // namespace

Inspection InspectRecord(const Record& record, const LogReport& report) {
  Inspection inspection;
  inspection.file = record.file;
  inspection.report = report;
  inspection.current_A = SpreadOf(record.current_A);
  inspection.voltage_V = SpreadOf(record.voltage_V);
  if (!record.temperature_degC.empty())
    inspection.temperature_degC = SpreadOf(record.temperature_degC);
  if (record.size() > 0) inspection.duration_s = record.time_s.back() - record.time_s.front();
  std::vector<double> steps_s;
  for (std::size_t k = 1; k < record.size(); ++k)
    steps_s.push_back(record.time_s[k] - record.time_s[k - 1]);
  inspection.sampling_s = SpreadOf(std::move(steps_s));
  inspection.segments = FindSegments(record);
  for (const Segment& segment : inspection.segments) {
    (segment.charge_C > 0.0 ? inspection.charge_out_C : inspection.charge_in_C) +=
        std::abs(segment.charge_C);
  }
  inspection.discharge = WholeDischarge(record);
  inspection.edge_resistance_Ohm = std::numeric_limits<double>::quiet_NaN();
  if (inspection.discharge && inspection.discharge->first > 0) {
    const std::size_t k = inspection.discharge->first;
    inspection.edge_resistance_Ohm = (record.voltage_V[k - 1] - record.voltage_V[k]) /
                                     (record.current_A[k] - record.current_A[k - 1]);
  }
  inspection.suggestion = SuggestKind(inspection.segments, inspection.discharge);
  return inspection;
}

std::vector<InspectedFile> InspectLogs(const std::vector<std::string>& files,
                                       const ReadOptions& options) {
  std::vector<InspectedFile> inspected(files.size());
  std::vector<LogToRead> logs;
  logs.reserve(files.size());
  for (const std::string& file : files) logs.push_back({file, options});
  auto problems = ReadLogs(logs, [&](std::size_t k, const Log& log) {
    inspected[k].inspection = InspectRecord(log.record, log.report);
  });
  for (std::size_t k = 0; k < files.size(); ++k) {
    inspected[k].file = files[k];
    inspected[k].problems = std::move(problems[k]);
  }
  return inspected;
}

}  // namespace lipoid
