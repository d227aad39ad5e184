#include "identify/health/stuck_sensor.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "identify/logs/columns.h"
#include "identify/logs/staircase.h"

namespace lipoid {
namespace {

// Changes that agree less than this do not tell what stands still.
constexpr double kLeastCoherence = 0.5;

// A voltage that moves less, by the mean square of its changes over that elsewhere, is one under a constant current.
constexpr double kMoves = 0.02;

// Of rows that show one value for as long.
std::vector<RowStretch> StretchesOfOneValue(const Record& record,
                                            const Column& values,
                                            double least_s) {
  std::vector<RowStretch> stretches;
  ForEachStretchOfOneValue(values, [&](const RowStretch& stretch) {
    if (record.time_s[stretch.second] - record.time_s[stretch.first] >= least_s)
      stretches.push_back(stretch);
  });
  return stretches;
}

// Of changes: those from one window to the next, or how these change in turn. A cell that relaxes moves from window to
// window, and hardly shows in the second.
enum class Order { kFirst, kSecond };

// Sums over changes of voltage and current.
struct Changes {
  double vv = 0.0, vi = 0.0, ii = 0.0, count = 0.0;

  [[nodiscard]] double coherence() const {
    return vv > 0.0 && ii > 0.0 ? -vi / std::sqrt(vv * ii) : 0.0;
  }
};

// For each stretch the changes between windows whose voltage was measured `after_s` after rows of it, and those of all
// others.
struct ChangesOf {
  std::vector<Changes> within;
  Changes elsewhere;
};

ChangesOf FindChanges(const FlightSamples& flight,
                      const std::vector<RowStretch>& stretches,
                      double after_s,
                      Order order = Order::kFirst) {
  const Record& record = flight.record;
  const Eigen::VectorXd current_A =
      flight.InWindows(Eigen::Map<const Eigen::VectorXd>(record.current_A.data(),
                                                         static_cast<Eigen::Index>(record.size())),
                       flight.lag_s);
  ChangesOf found{std::vector<Changes>(stretches.size()), {}};
  std::size_t s = 0;
  const auto change = [&](const Eigen::VectorXd& of, Eigen::Index k) {
    return order == Order::kFirst ? of[k] - of[k - 1] : of[k] - 2.0 * of[k - 1] + of[k - 2];
  };
  const std::size_t before = order == Order::kFirst ? 1 : 2;
  for (std::size_t w = before; w < flight.windows.size(); ++w) {
    const double from_s = record.time_s[flight.fresh[flight.windows[w - before].first]] - after_s;
    const double to_s = record.time_s[flight.fresh[flight.windows[w].second - 1]] - after_s;
    while (s < stretches.size() && record.time_s[stretches[s].second] < to_s) ++s;
    const bool is_within = s < stretches.size() && from_s >= record.time_s[stretches[s].first];
    Changes& of = is_within ? found.within[s] : found.elsewhere;
    const auto k = static_cast<Eigen::Index>(w);
    const double dv = change(flight.voltage_V, k);
    const double di = change(current_A, k);
    of.vv += dv * dv;
    of.vi += dv * di;
    of.ii += di * di;
    of.count += 1.0;
  }
  return found;
}

// For how long the current stands at its largest value, to which a sensor at the end of its range comes back again and
// again; 0 where that is one of its values like others, or the voltage stands with it.
double TimeAtEnd(const FlightSamples& flight) {
  constexpr double kLeastShare = 0.03;  // of the flight
  constexpr std::size_t kVisits = 3;
  constexpr std::size_t kLevels =
      50;  // other values: fewer are those of a coarse sensor, or of a load that is set
  constexpr std::size_t kFrequent = 5;  // times the rows of any of them
  const Record& record = flight.record;
  std::vector<double> rising(record.current_A.begin(), record.current_A.end());
  std::sort(rising.begin(), rising.end());
  std::vector<std::size_t> rows;  // of each value
  for (std::size_t k = 0; k < rising.size(); ++k) {
    if (k == 0 || rising[k] != rising[k - 1]) rows.push_back(0);
    ++rows.back();
  }
  const std::size_t at_largest = rows.back();
  rows.pop_back();
  if (rows.size() < kLevels || at_largest < kFrequent * *std::max_element(rows.begin(), rows.end()))
    return 0.0;
  std::vector<RowStretch> stretches = StretchesOfOneValue(record, record.current_A, 0.0);
  std::erase_if(stretches,
                [&](const RowStretch& s) { return record.current_A[s.first] != rising.back(); });
  double end_s = 0.0;
  for (const auto& [first, last] : stretches) end_s += record.time_s[last] - record.time_s[first];
  if (stretches.size() < kVisits ||
      end_s < kLeastShare * (record.time_s.back() - record.time_s.front()))
    return 0.0;
  const ChangesOf changes = FindChanges(flight, stretches, flight.lag_s);
  Changes within;
  for (const Changes& of : changes.within) {
    within.vv += of.vv;
    within.count += of.count;
  }
  const bool moves =
      within.vv * changes.elsewhere.count > kMoves * changes.elsewhere.vv * within.count;
  return moves ? end_s : 0.0;
}

}  // namespace

std::vector<RowStretch> FindStuckVoltage(const FlightSamples& flight) {
  constexpr double kSteps = 3.0;
  const Record& record = flight.record;
  const double least_s = std::max(10.0, 20.0 * flight.voltage_update_s);
  const double least_at_end_s = std::max(2.0, 5.0 * flight.voltage_update_s);
  const Extent extent = FindExtent(record.voltage_V);
  std::vector<RowStretch> stretches = StretchesOfOneValue(record, record.voltage_V, least_at_end_s);
  std::erase_if(stretches, [&](const RowStretch& stretch) {
    const double shown_V = record.voltage_V[stretch.first];
    const bool is_end = shown_V == extent.least || shown_V == extent.most;
    return !is_end && record.time_s[stretch.second] - record.time_s[stretch.first] < least_s;
  });
  if (stretches.empty()) return stretches;
  const ChangesOf changes = FindChanges(flight, stretches, 0.0);
  const Changes& elsewhere = changes.elsewhere;
  if (elsewhere.coherence() < kLeastCoherence) return {};
  const double resistance_Ohm = -elsewhere.vi / elsewhere.ii;
  const double least_V = kSteps * StepOf(record.voltage_V);
  std::size_t kept = 0;
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    const Changes& within = changes.within[s];
    if (resistance_Ohm * std::sqrt(within.ii / within.count) > least_V)
      stretches[kept++] = stretches[s];
  }
  stretches.resize(kept);
  return stretches;
}

std::string DoubtAboutStuckCurrent(const FlightSamples& flight) {
  const Record& record = flight.record;
  if (const double end_s = TimeAtEnd(flight); end_s > 0.0) {
    return fmt::format(
        "the current shows {:.4g} A, and never more, for {:.3g} s in all while the voltage moves as under one that "
        "changes: the sensor measures no larger current, and neither charge nor resistance of this log is right",
        FindExtent(record.current_A).most,
        end_s);
  }
  constexpr double kUpdates = 10.0;
  constexpr double kFewest = 10.0;  // changes
  constexpr double kNoise = 4.0;  // times what of the voltage is not the current's doing elsewhere
  const std::vector<RowStretch> stretches = StretchesOfOneValue(
      record, record.current_A, kUpdates * std::max(flight.current_update_s, flight.window_s));
  if (stretches.empty()) return "";
  const ChangesOf changes = FindChanges(flight, stretches, flight.lag_s, Order::kSecond);
  const Changes& elsewhere = changes.elsewhere;
  const double coherence = elsewhere.coherence();
  if (elsewhere.count < kFewest || coherence < kLeastCoherence) return "";
  const double unexplained = 1.0 - coherence * coherence;
  const double least_V2 = std::max(kNoise * unexplained, kMoves) * elsewhere.vv / elsewhere.count;
  for (std::size_t s = 0; s < stretches.size(); ++s) {
    const Changes& within = changes.within[s];
    if (within.count < kFewest || within.vv / within.count < least_V2) continue;
    const auto [first, last] = stretches[s];
    return fmt::format(
        "the current shows {:.4g} A from {:.5g} to {:.5g} s while the voltage moves as under one that changes: the "
        "sensor was stuck, and neither charge nor resistance of this log is right",
        record.current_A[first],
        record.time_s[first],
        record.time_s[last]);
  }
  return "";
}

}  // namespace lipoid
