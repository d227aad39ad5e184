#include "identify/stages/start_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/logs/constancy.h"
#include "identify/logs/segments.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

double Median(std::vector<double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// A step of the current between two rows: how much it shows, and how soon after.
struct Edge {
  double resistance_Ohm;
  double interval_s;
};

void CollectEdges(const Record& record, std::vector<Edge>& edges) {
  double largest = 0.0;
  for (const double i : record.current_A) largest = std::max(largest, std::abs(i));
  for (std::size_t k = 1; k < record.size(); ++k) {
    const double step_A = record.current_A[k] - record.current_A[k - 1];
    if (std::abs(step_A) < 0.2 * largest) continue;
    const double resistance = -(record.voltage_V[k] - record.voltage_V[k - 1]) / step_A;
    if (resistance > 0.0) edges.push_back({resistance, record.time_s[k] - record.time_s[k - 1]});
  }
}

}  // namespace

StartValues FindStartValues(const std::vector<const Record*>& records) {
  StartValues start;
  start.longest_s = 0.0;
  std::vector<Edge> edges;
  std::vector<double> times;
  std::vector<double> recoveries;
  double shortest = std::numeric_limits<double>::infinity();
  for (const Record* record : records) {
    CollectEdges(*record, edges);
    for (std::size_t k = 1; k < record->size(); ++k) {
      shortest = std::min(shortest, record->time_s[k] - record->time_s[k - 1]);
    }
    const auto segments = FindSegments(*record);
    for (std::size_t s = 0; s < segments.size(); ++s) {
      start.longest_s = std::max(start.longest_s, segments[s].duration_s());
      if (s == 0 || segments[s].kind != SegmentKind::kRest ||
          segments[s - 1].kind == SegmentKind::kRest)
        continue;
      const Segment& rest = segments[s];
      if (rest.last < rest.first + 4) continue;
      // From the first row at rest, when the series resistance has let go, to the last.
      const double from_V = record->voltage_V[rest.first];
      const double rise_V = record->voltage_V[rest.last] - from_V;
      const double load_A = segments[s - 1].current_A;
      if (!(rise_V / load_A > 0.0)) continue;
      std::size_t k = rest.first;
      while (k < rest.last && (record->voltage_V[k] - from_V) / rise_V < 0.632) ++k;
      times.push_back(record->time_s[k] - record->time_s[rest.first]);
      recoveries.push_back(rise_V / load_A);
    }
  }
  // Slowly sampled steps contain what relaxes in between: keep those near the quickest quarter.
  std::vector<double> intervals;
  intervals.reserve(edges.size());
  for (const Edge& edge : edges) intervals.push_back(edge.interval_s);
  std::sort(intervals.begin(), intervals.end());
  std::vector<double> resistances;
  for (const Edge& edge : edges) {
    if (edge.interval_s <= 1.5 * intervals[intervals.size() / 4])
      resistances.push_back(edge.resistance_Ohm);
  }
  start.edges = static_cast<int>(resistances.size());
  start.relaxations = static_cast<int>(times.size());
  start.series_resistance_Ohm = Median(std::move(resistances));
  start.relaxation_s = Median(std::move(times));
  start.relaxation_Ohm = Median(std::move(recoveries));
  start.shortest_s = std::isfinite(shortest) ? shortest : 1.0;
  start.longest_s = std::max(start.longest_s, 4.0 * start.shortest_s);
  return start;
}

ThinnedRecord Thin(const Record& record, std::size_t most_rows) {
  Require(most_rows >= 2, "most_rows >= 2", {{"most_rows", static_cast<double>(most_rows)}});
  ThinnedRecord thinned;
  thinned.record.file = record.file;
  thinned.record.hold = record.hold;
  const bool backward = record.hold == Hold::kBackward;
  const std::size_t n = record.size();
  double largest = 0.0;
  for (const double i : record.current_A) largest = std::max(largest, std::abs(i));
  // Rows of one level differ by their noise: six deviations, or a noisy log would not get short.
  const double noise_A = n > 0 ? RowNoise(record.current_A, 0, n - 1) : 0.0;
  const double tolerance_A = std::max(1e-3 * largest, 6.0 * noise_A);
  // Steps grow geometrically after each change of the current, so that quick relaxations keep their
  // rows.
  for (double growth = 0.02;; growth *= 2.0) {
    auto& out = thinned.record;
    out.time_s.clear();
    out.current_A.clear();
    out.voltage_V.clear();
    thinned.row_weight.clear();
    std::size_t k = 0;
    double change_s = n > 0 ? record.time_s[0] : 0.0;
    while (k < n) {
      // Row k ends a step that began at the row before; `held` flowed over it.
      const auto held = [&](std::size_t row) {
        return record.current_A[backward || row == 0 ? row : row - 1];
      };
      if (k > 0 && std::abs(held(k) - held(k - 1)) > tolerance_A) change_s = record.time_s[k - 1];
      std::size_t last = k;
      double charge_C = k > 0 ? held(k) * (record.time_s[k] - record.time_s[k - 1]) : 0.0;
      while (k > 0 && last + 1 < n && std::abs(held(last + 1) - held(k)) <= tolerance_A &&
             std::abs(record.current_A[last + 1] - record.current_A[k]) <= tolerance_A &&
             record.time_s[last + 1] - record.time_s[k - 1] <=
                 growth * (record.time_s[last + 1] - change_s)) {
        ++last;
        charge_C += held(last) * (record.time_s[last] - record.time_s[last - 1]);
      }
      out.time_s.push_back(record.time_s[last]);
      out.voltage_V.push_back(record.voltage_V[last]);
      out.current_A.push_back(record.current_A[last]);
      // A merged step carries its mean current, named by the row that closes it or, forward, that
      // opens it.
      if (last > k) {
        out.current_A[out.size() - (backward ? 1 : 2)] =
            charge_C / (record.time_s[last] - record.time_s[k - 1]);
      }
      thinned.row_weight.push_back(static_cast<double>(last - k + 1));
      k = last + 1;
    }
    if (out.time_s.size() <= most_rows || growth > 1.0) return thinned;
  }
}

}  // namespace lipoid
