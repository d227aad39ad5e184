#include "identify/logs/discharge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "identify/logs/columns.h"
#include "identify/logs/constancy.h"
#include "identify/logs/plausibility.h"
#include "model/battery/cell.h"
#include "model/core/counted.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

constexpr double kMinorShare =
    0.01;  // of the charge: a load that moves less is a check, no discharge
constexpr double kMaxChargingShare = 0.05;  // of the discharged charge
constexpr double kMaxRestShare = 0.05;      // of the time from switch-on to the end

[[noreturn]] void Refuse(const Record& record, const std::string& message) {
  throw LoadError({.file = record.file}, message);
}

bool IsRest(const Segment& segment) { return segment.kind == SegmentKind::kRest; }

// A discharge, or why there is none as a sentence that follows "found".
struct Found {
  std::optional<Discharge> discharge;
  std::string instead;
};

// Of the last row under load, where its interval is a small part of the discharge.
double LastFall(const Record& record, const Segment& first, const Segment& last) {
  constexpr double kSmallPart = 0.01;
  if (last.last == first.first) return 0.0;
  const double interval_s = record.time_s[last.last] - record.time_s[last.last - 1];
  if (interval_s > kSmallPart * (last.end_s - first.start_s)) return 0.0;
  return record.voltage_V[last.last - 1] - record.voltage_V[last.last];
}

// The one discharge of a record: its loaded rows, without anything about its end.
Found LookForDischarge(const Record& record) {
  const auto segments = FindSegments(record);
  double out_C = 0.0;
  double in_C = 0.0;
  for (const Segment& segment : segments) {
    if (!IsRest(segment)) (segment.charge_C > 0.0 ? out_C : in_C) += std::abs(segment.charge_C);
  }
  if (out_C == 0.0 && in_C == 0.0) {
    return {{}, "no current but rest over " + Counted(record.size(), "row")};
  }
  if (in_C > kMaxChargingShare * out_C) {
    return {{},
            fmt::format("{:.4g} Ah of charging beside {:.4g} Ah of discharging; choose the part of "
                        "the log with steps, cycles or start_s and end_s, or settle the sign with "
                        "current_sign",
                        in_C / 3600.0,
                        out_C / 3600.0)};
  }
  const auto major = [&](const Segment& segment) {
    return !IsRest(segment) && segment.charge_C > kMinorShare * out_C;
  };
  auto first = std::find_if(segments.begin(), segments.end(), major);
  const auto end = std::find_if(segments.rbegin(), segments.rend(), major).base();
  if (first == segments.end()) return {{}, "a current that changes all the time"};
  // An edge too slow to belong to its level is part of the discharge all the same.
  while (first != segments.begin() && !IsRest(*(first - 1))) --first;
  const Segment& last = *(end - 1);
  double rest_s = 0.0;
  std::size_t rests = 0;
  for (auto segment = first; segment != end; ++segment) {
    if (!IsRest(*segment)) continue;
    rest_s += segment->duration_s();
    ++rests;
  }
  if (rest_s > kMaxRestShare * (last.end_s - first->start_s)) {
    return {{},
            fmt::format("{} inside it, {:.6g} s of {:.6g} s; a log of pulses is of kind \"pulses\"",
                        Counted(rests, "rest"),
                        rest_s,
                        last.end_s - first->start_s)};
  }
  const Constancy constancy = MeasureConstancy(record, first->first, last.last);
  if (!constancy.constant()) {
    const auto row = [&](std::size_t k) {
      return record.current_A.begin() + static_cast<std::ptrdiff_t>(k);
    };
    const auto [least, most] = std::minmax_element(row(first->first), row(last.last + 1));
    return {{},
            fmt::format("{:.0f} % of the charge at over {:.0f} % from the median of {:.4g} A (rows "
                        "from {:.4g} A to {:.4g} A)",
                        100.0 * constancy.charge_off_median,
                        100.0 * kOffMedian,
                        constancy.median_A,
                        *least,
                        *most)};
  }
  Discharge discharge{.first = first->first,
                      .last = last.last,
                      .start_s = first->start_s,
                      .end_s = last.end_s,
                      .end_voltage_V = kNaN};
  if (record.voltage_V.empty()) return {discharge, {}};
  discharge.end_voltage_V = record.voltage_V[last.last];
  discharge.voltage_noise_V = RowNoise(record.voltage_V, first->first, last.last);
  discharge.last_fall_V = LastFall(record, *first, last);
  return {discharge, {}};
}

Discharge OneDischarge(const Record& record, std::string_view expected) {
  RefuseWithoutVoltage(record);
  Found found = LookForDischarge(record);
  if (!found.discharge)
    Refuse(record, fmt::format("expected {}, found {}", expected, found.instead));
  return *found.discharge;
}

// Charge and mean current between start_s and end_s, exact for either hold.
void MeasureCharge(const Record& record, Discharge& discharge) {
  const auto& t = record.time_s;
  // What flows of the interval that ends at row k.
  const auto part_C = [&](std::size_t k) {
    const double from_s = std::max(t[k - 1], discharge.start_s);
    const double to_s = std::min(t[k], discharge.end_s);
    const double current_A = record.current_A[record.hold == Hold::kBackward ? k : k - 1];
    return to_s > from_s ? current_A * (to_s - from_s) : 0.0;
  };
  // The rows within, and the intervals cut at either end.
  const auto first =
      static_cast<std::size_t>(std::lower_bound(t.begin(), t.end(), discharge.start_s) - t.begin());
  const auto end =
      static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), discharge.end_s) - t.begin());
  discharge.charge_C = 0.0;
  if (first < end) {
    if (first > 0) discharge.charge_C += part_C(first);
    discharge.charge_C += CountCharge(record, first, end - 1).charge_C;
  }
  if (end > 0 && end < t.size()) discharge.charge_C += part_C(end);
  discharge.current_A = discharge.charge_C / discharge.time_s();
}

// A voltage under load and when it was there.
struct Point {
  double time_s = 0.0;
  double voltage_V = 0.0;
  std::size_t row = 0;  // the latest row that took part
};

// The voltages under load: the rows, or averages over as many of them as it takes to see through
// the noise.
std::vector<Point> LoadedVoltages(const Record& record, const Discharge& discharge) {
  constexpr double kSharp_V = 0.0005;
  constexpr double kMaxTimeShare = 0.005;  // the knee before cut-off must not be smoothed away
  const std::size_t rows = discharge.last - discharge.first + 1;
  const double wanted = std::pow(discharge.voltage_noise_V / kSharp_V, 2);
  const auto average = static_cast<std::size_t>(
      std::clamp(std::min(wanted, kMaxTimeShare * static_cast<double>(rows)), 1.0, 1e9));
  std::vector<Point> points;
  points.reserve(rows / average + 1);
  // Groups are counted from the end, where it matters.
  for (std::size_t end = discharge.first + rows % average; end <= discharge.last + 1;
       end += average) {
    if (end < discharge.first + average) continue;
    Point point{.row = end - 1};
    for (std::size_t k = end - average; k < end; ++k) {
      point.time_s += record.time_s[k] / static_cast<double>(average);
      point.voltage_V += record.voltage_V[k] / static_cast<double>(average);
    }
    points.push_back(point);
  }
  // The current flows on after the last stamp that carries its voltage: after the middle of the
  // last group, and with forward hold after the last row.
  if (points.size() >= 2 && points.back().time_s < discharge.end_s) {
    const Point& a = points[points.size() - 2];
    const Point& b = points.back();
    const double slope = (b.voltage_V - a.voltage_V) / (b.time_s - a.time_s);
    points.push_back({.time_s = discharge.end_s,
                      .voltage_V = b.voltage_V + slope * (discharge.end_s - b.time_s),
                      .row = discharge.last});
  }
  return points;
}

}  // namespace

double CutoffTolerance(const Discharge& discharge) {
  constexpr double kMostOfFall_V = 0.05;
  return std::max(discharge.nearness_V(), std::min(2.0 * discharge.last_fall_V, kMostOfFall_V));
}

bool IsBelowCutoff(const Cell& cell,
                   double current_A,
                   double voltage_V,
                   std::size_t rows_before,
                   std::size_t rows_of_log) {
  constexpr double kLastStep_V = 0.3;
  const bool last = rows_before > 0 && rows_before + 1 == rows_of_log;
  if (std::isnan(voltage_V)) return true;
  return current_A > 0.0 && voltage_V < cell.series * (cell.cutoff_V - kCutoffTolerance_V -
                                                       (last ? kLastStep_V : 0.0));
}

Discharge FindDischarge(const Record& record, double cutoff_V) {
  Discharge discharge = OneDischarge(record, "one discharge at constant current");
  const auto points = LoadedVoltages(record, discharge);
  const double tolerance_V = CutoffTolerance(discharge);
  const auto crossing = std::find_if(points.begin(), points.end(), [&](const Point& point) {
    return point.voltage_V <= cutoff_V;
  });
  if (crossing == points.begin()) {
    Refuse(
        record,
        fmt::format(
            "expected a discharge that starts above the cut-off of {:.4g} V, found {:.4g} V in the "
            "first row under load",
            cutoff_V,
            crossing->voltage_V));
  }
  if (crossing != points.end()) {
    const Point& above = *(crossing - 1);
    const double share = (above.voltage_V - cutoff_V) / (above.voltage_V - crossing->voltage_V);
    discharge.end_s = above.time_s + share * (crossing->time_s - above.time_s);
    discharge.end_voltage_V = cutoff_V;
    discharge.last = crossing->row;
  } else {
    const auto lowest =
        std::min_element(points.begin(), points.end(), [](const Point& a, const Point& b) {
          return a.voltage_V < b.voltage_V;
        });
    if (lowest->voltage_V > cutoff_V + tolerance_V) {
      Refuse(record,
             fmt::format(
                 "expected the voltage to reach the cut-off of {:.4g} V within {:.2g} mV, "
                 "found {:.4f} V as the lowest under load, at {:.6g} s; if the cell "
                 "was empty there, set cutoff_V to that voltage; else log the discharge to its "
                 "end, or call it one of kind \"validation\"",
                 cutoff_V,
                 1000.0 * tolerance_V,
                 lowest->voltage_V,
                 lowest->time_s));
    }
    discharge.end_s = lowest->time_s;
    discharge.end_voltage_V = lowest->voltage_V;
    discharge.last = lowest->row;
  }
  MeasureCharge(record, discharge);
  return discharge;
}

Discharge FindLowRateDischarge(const Record& record, double capacity_Ah) {
  Discharge discharge = OneDischarge(record, "one slow discharge at constant current");
  MeasureCharge(record, discharge);
  const bool nominal = capacity_Ah > 0.0;
  const double rate_per_h =
      discharge.current_A / (nominal ? capacity_Ah : discharge.charge_C / 3600.0);
  if (rate_per_h > kMaxLowRate_per_h) {
    Refuse(record,
           fmt::format("expected a low rate, at most {:.2g} C, found {:.3g} C ({:.4g} A for a {} "
                       "of {:.4g} Ah)",
                       kMaxLowRate_per_h,
                       rate_per_h,
                       discharge.current_A,
                       nominal ? "capacity" : "charge",
                       nominal ? capacity_Ah : discharge.charge_C / 3600.0));
  }
  return discharge;
}

std::optional<Discharge> WholeDischarge(const Record& record) {
  auto found = LookForDischarge(record).discharge;
  if (found) MeasureCharge(record, *found);
  return found;
}

namespace {

// Of segments that might be rests, but for a small current in all of them.
std::string DoubtAboutZero(const std::vector<Segment>& segments) {
  constexpr double kSmall = 0.02;  // of the largest current
  double largest_A = 0.0;
  for (const Segment& segment : segments)
    largest_A = std::max(largest_A, std::abs(segment.current_A));
  std::vector<double> small_A;
  for (const Segment& segment : segments) {
    if (std::abs(segment.current_A) <= kSmall * largest_A) small_A.push_back(segment.current_A);
  }
  if (small_A.size() < 2) return "";
  return fmt::format(
      "; {:.3g} A flow between them: if the cell rests there, the zero of the current sensor is off by that, and is "
      "to be subtracted first",
      UpperMedian(std::move(small_A)));
}

}  // namespace

std::vector<Segment> FindPulses(const Record& record) {
  auto segments = FindSegments(record);
  std::size_t loads = 0;
  for (std::size_t k = 0; k < segments.size(); ++k) {
    if (IsRest(segments[k])) continue;
    ++loads;
    const bool relaxes =
        k + 1 < segments.size() && IsRest(segments[k + 1]) && segments[k + 1].rows() >= kRestRows;
    if (relaxes) return segments;
  }
  if (loads == 0)
    Refuse(record,
           "expected pulses, found no current but rest over " + Counted(record.size(), "row"));
  Refuse(record,
         fmt::format("expected pulses with rests between them, found {} and no rest after "
                     "any{}; a discharge is of kind \"constant-current\", any other load of kind "
                     "\"validation\"",
                     Counted(loads, "load"),
                     DoubtAboutZero(segments)));
}

}  // namespace lipoid
