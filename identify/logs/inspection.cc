#include "identify/logs/inspection.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "identify/logs/formats/formats.h"
#include "identify/logs/plausibility.h"
#include "identify/logs/read_logs.h"
#include "model/core/counted.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

Spread SpreadOf(std::vector<double> values) {
  if (values.empty()) return {};
  const auto [least, largest] = std::minmax_element(values.begin(), values.end());
  Spread spread{.least = *least, .largest = *largest};
  spread.median = UpperMedian(std::move(values));
  return spread;
}

// Some points of a discharge: enough to read a state of charge from a voltage.
std::vector<std::pair<double, double>> CurveOf(const Record& record, const Discharge& discharge) {
  constexpr std::size_t kPoints = 200;
  std::vector<std::pair<double, double>> curve;
  if (record.voltage_V.empty()) return curve;
  const std::vector<double> charge_C = DeliveredCharge(record);
  const double before_C = discharge.first > 0 ? charge_C[discharge.first - 1] : 0.0;
  const std::size_t rows = discharge.last - discharge.first + 1;
  const std::size_t step = std::max<std::size_t>(1, rows / kPoints);
  for (std::size_t first = discharge.first; first <= discharge.last; first += step) {
    // Means: on a flat curve the noise of a single row is some hundredths of the charge.
    const std::size_t end = std::min(first + step, discharge.last + 1);
    double taken_C = 0.0;
    double sum_V = 0.0;
    for (std::size_t k = first; k < end; ++k) {
      taken_C += charge_C[k] - before_C;
      sum_V += record.voltage_V[k];
    }
    const auto count = static_cast<double>(end - first);
    curve.emplace_back(1.0 - taken_C / count / discharge.charge_C, sum_V / count);
  }
  return curve;
}

// Over the last twentieth of a rest: less than a cell still relaxes there, and less noise than a single row has.
double RestedVoltage(const Record& record, const Segment& rest) {
  constexpr double kShare = 0.05;
  const double from_s =
      record.time_s[rest.last] - kShare * (record.time_s[rest.last] - record.time_s[rest.first]);
  double sum_V = 0.0;
  double count = 0.0;
  for (std::size_t k = rest.last + 1; k-- > rest.first && record.time_s[k] >= from_s;) {
    sum_V += record.voltage_V[k];
    count += 1.0;
  }
  return sum_V / count;
}

// What a load holds that does not hold the current: its power, or its resistance. Empty where neither is steadier.
std::string HeldInstead(const Record& record, const Discharge& discharge) {
  constexpr double kMoves = 0.03;     // between the 5th and the 95th of a hundred rows
  constexpr double kSteadier = 0.25;  // than the current
  if (record.voltage_V.empty()) return "";
  std::vector<double> power_W;
  std::vector<double> load_Ohm;
  std::vector<double> current_A;
  for (std::size_t k = discharge.first; k <= discharge.last; ++k) {
    if (!(record.current_A[k] > 0.0)) continue;
    current_A.push_back(record.current_A[k]);
    power_W.push_back(record.voltage_V[k] * record.current_A[k]);
    load_Ohm.push_back(record.voltage_V[k] / record.current_A[k]);
  }
  constexpr std::size_t kLeastRows = 20;
  if (current_A.size() < kLeastRows) return "";
  const auto at = [](std::vector<double>& of, double share) {
    return ValueAtPlace(of, static_cast<std::size_t>(share * static_cast<double>(of.size() - 1)));
  };
  const auto spread = [&](std::vector<double>& of) {
    return (at(of, 0.95) - at(of, 0.05)) / at(of, 0.5);
  };
  const double moves = spread(current_A);
  const bool power = spread(power_W) < kSteadier * moves;
  if (!(moves > kMoves) || !(power || spread(load_Ohm) < kSteadier * moves)) return "";
  return fmt::format(
      "a discharge at a constant {} of {:.4g} {}: its current moves by {:.2g} %, and the law of discharge times (4.53) is one of constant currents",
      power ? "power" : "resistance",
      at(power ? power_W : load_Ohm, 0.5),
      power ? "W" : "Ohm",
      100.0 * moves);
}

Inspection InspectRows(const Record& record, const LogReport& report) {
  Inspection inspection;
  inspection.file = record.file;
  inspection.report = report;
  inspection.current_A = SpreadOf(record.current_A.ToVector());
  if (!record.voltage_V.empty()) inspection.voltage_V = SpreadOf(record.voltage_V.ToVector());
  if (!record.temperature_degC.empty())
    inspection.temperature_degC = SpreadOf(record.temperature_degC.ToVector());
  if (record.size() > 0) inspection.duration_s = record.time_s.back() - record.time_s.front();
  std::vector<double> steps_s;
  for (std::size_t k = 1; k < record.size(); ++k)
    steps_s.push_back(record.time_s[k] - record.time_s[k - 1]);
  inspection.sampling_s = SpreadOf(std::move(steps_s));
  if (const auto& thinned = report.thinned)
    inspection.sampling_s = {thinned->shortest_s, thinned->median_s, thinned->longest_s};
  inspection.segments = FindSegments(record);
  for (const Segment& segment : inspection.segments) {
    (segment.charge_C > 0.0 ? inspection.charge_out_C : inspection.charge_in_C) +=
        std::abs(segment.charge_C);
  }
  inspection.discharge = WholeDischarge(record);
  inspection.edge_resistance_Ohm = std::numeric_limits<double>::quiet_NaN();
  if (inspection.discharge && inspection.discharge->first > 0 && !record.voltage_V.empty()) {
    const std::size_t k = inspection.discharge->first;
    inspection.edge_resistance_Ohm = (record.voltage_V[k - 1] - record.voltage_V[k]) /
                                     (record.current_A[k] - record.current_A[k - 1]);
  }
  if (inspection.discharge) inspection.discharge_curve = CurveOf(record, *inspection.discharge);
  if (!inspection.segments.empty() && inspection.segments[0].kind == SegmentKind::kRest &&
      inspection.segments.size() > 1 && !record.voltage_V.empty()) {
    inspection.start_voltage_V = RestedVoltage(record, inspection.segments[0]);
  }
  inspection.suggestion =
      report.flight ? Suggestion{std::nullopt, "a flight, which is no test of a laboratory"}
                    : SuggestKind(inspection.segments, inspection.discharge);
  if (inspection.suggestion.kind == LogKind::kConstantCurrent) {
    if (auto other = HeldInstead(record, *inspection.discharge); !other.empty())
      inspection.suggestion = {LogKind::kValidation, std::move(other)};
  }
  return inspection;
}

}  // namespace

Suggestion SuggestKind(const std::vector<Segment>& segments,
                       const std::optional<Discharge>& discharge) {
  std::size_t loads = 0;
  std::size_t pulses = 0;
  std::size_t relaxations = 0;
  std::size_t varying = 0;
  double out_C = 0.0;
  double in_C = 0.0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (segments[k].kind == SegmentKind::kRest) continue;
    ++loads;
    (segments[k].charge_C > 0.0 ? out_C : in_C) += std::abs(segments[k].charge_C);
    if (segments[k].kind == SegmentKind::kVarying) ++varying;
    if (segments[k].kind != SegmentKind::kPulse) continue;
    ++pulses;
    const bool relaxes = k + 1 < segments.size() && segments[k + 1].kind == SegmentKind::kRest &&
                         segments[k + 1].rows() >= kRestRows;
    if (relaxes) ++relaxations;
  }
  if (loads == 0) return {{}, "only rest"};
  constexpr std::size_t kMostVarying = 4;  // for each pulse; a drive cycle has ten
  if (relaxations > 0 && varying <= kMostVarying * pulses) {
    return {
        LogKind::kPulses,
        fmt::format("{}, {} of them followed by a rest", Counted(pulses, "pulse"), relaxations)};
  }
  if (discharge) {
    const double charge_Ah = discharge->charge_C / 3600.0;
    const double rate_per_h = discharge->current_A / charge_Ah;
    const bool low = rate_per_h <= kMaxLowRate_per_h;
    return {low ? LogKind::kLowRate : LogKind::kConstantCurrent,
            fmt::format("one discharge of {:.4g} Ah at {:.4g} A, {:.2g} C of its own charge",
                        charge_Ah,
                        discharge->current_A,
                        rate_per_h)};
  }
  if (out_C == 0.0) {
    return {{},
            "only charging; a slow charge takes part in a campaign as `low-rate-charge`, with its "
            "`initial_soc`"};
  }
  if (in_C > 0.5 * out_C) {
    return {LogKind::kValidation,
            "charges and discharges; for another kind choose a part with steps, cycles or times"};
  }
  if (relaxations > 0) {
    return {LogKind::kValidation,
            fmt::format(
                "{}, {} of them varying, as in a drive cycle", Counted(loads, "load"), varying)};
  }
  return {LogKind::kValidation,
          fmt::format("{} without a pulse followed by a rest", Counted(loads, "load"))};
}

int CellsInSeries(const Inspection& log) {
  const int told = log.report.flight ? log.report.flight->cells : 0;
  if (told > 0) return told;
  return log.voltage_V ? CellsInSeries(log.voltage_V->largest) : 1;
}

Inspection InspectRecord(const Record& record, const LogReport& report) {
  Inspection inspection = InspectRows(record, report);
  for (const LogPart& part : FindParts(record, inspection.segments, report.gaps)) {
    Inspection one = InspectRows(RowsOf(record, part), report);
    one.part = part;
    one.report.gaps.clear();
    one.part_start_s = record.time_s[part.first];
    one.part_end_s = record.time_s[part.last];
    inspection.parts.push_back(std::move(one));
  }
  return inspection;
}

std::vector<InspectedFile> InspectLogs(const std::vector<std::string>& files,
                                       const ReadOptions& options,
                                       const SeenRecord& seen) {
  std::vector<InspectedFile> inspected(files.size());
  std::vector<LogToRead> logs;
  logs.reserve(files.size());
  for (const std::string& file : files) logs.push_back({file, options});
  auto problems = ReadLogs(logs, [&](std::size_t k, const Log& log) {
    inspected[k].inspection = InspectRecord(log.record, log.report);
    if (seen) seen(k, log.record);
  });
  for (std::size_t k = 0; k < files.size(); ++k) {
    inspected[k].file = files[k];
    inspected[k].problems = std::move(problems[k]);
    inspected[k].no_log = !inspected[k].inspection && IsNoLog(files[k], options);
  }
  return inspected;
}

}  // namespace lipoid
