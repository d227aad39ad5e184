#include "identify/stages/start_values.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/logs/columns.h"
#include "model/core/errors.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// A step of the current between two rows: how much it shows, and how soon after.
struct CurrentEdge {
  double resistance_Ohm;
  double interval_s;
};

void CollectEdges(const Record& record, std::vector<CurrentEdge>& edges) {
  const double largest = LargestMagnitude(record.current_A);
  for (std::size_t k = 1; k < record.size(); ++k) {
    const double step_A = record.current_A[k] - record.current_A[k - 1];
    if (std::abs(step_A) < 0.2 * largest) continue;
    const double resistance = -(record.voltage_V[k] - record.voltage_V[k - 1]) / step_A;
    if (resistance > 0.0) edges.push_back({resistance, record.time_s[k] - record.time_s[k - 1]});
  }
}

}  // namespace

StartValues FindStartValues(const std::vector<const Record*>& records,
                            const std::vector<std::vector<Segment>>& known_segments) {
  Require(known_segments.empty() || known_segments.size() == records.size(),
          "the segments of every record or of none");
  StartValues start;
  start.longest_s = 0.0;
  std::vector<CurrentEdge> edges;
  std::vector<double> times;
  std::vector<double> recoveries;
  double shortest = std::numeric_limits<double>::infinity();
  for (std::size_t n = 0; n < records.size(); ++n) {
    const Record* const record = records[n];
    CollectEdges(*record, edges);
    shortest = std::min(shortest, ShortestInterval(record->time_s));
    const auto segments = known_segments.empty() ? FindSegments(*record) : known_segments[n];
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
  for (const CurrentEdge& edge : edges) intervals.push_back(edge.interval_s);
  std::sort(intervals.begin(), intervals.end());
  std::vector<double> resistances;
  for (const CurrentEdge& edge : edges) {
    if (edge.interval_s <= 1.5 * intervals[intervals.size() / 4])
      resistances.push_back(edge.resistance_Ohm);
  }
  start.series_resistance_Ohm = UpperMedian(std::move(resistances));
  start.relaxation_s = UpperMedian(std::move(times));
  start.relaxation_Ohm = UpperMedian(std::move(recoveries));
  start.shortest_s = std::isfinite(shortest) ? shortest : 1.0;
  start.longest_s = std::max(start.longest_s, 4.0 * start.shortest_s);
  return start;
}

}  // namespace lipoid
