#include "identify/health/flight_samples.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "identify/health/followed_current.h"
#include "identify/health/stuck_sensor.h"
#include "identify/logs/columns.h"
#include "identify/logs/flight/flight_log.h"
#include "identify/logs/flight/updates.h"
#include "identify/logs/gaps.h"
#include "identify/logs/staircase.h"
#include "model/core/errors.h"
#include "model/core/foreign_text.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Rows closer together are averaged: nothing in a cell that a flight log can show is faster.
constexpr double kShortestStep_s = 0.05;
// Windows that are fitted. More add no information but take longer.
constexpr std::size_t kMostWindows = 2500;
constexpr double kLongestWindow_s = 5.0;
// A last row whose voltage has left by this much while no more current flows was measured while the
// plug was pulled.
constexpr double kUnpluggedFall = 0.03;
constexpr std::size_t kUnplugRows = 3;

Record Thinned(const Record& record) {
  const auto temperature_degC = WithoutSteps(record.time_s, record.temperature_degC);
  const bool warm = !temperature_degC.empty();
  if (MedianInterval(record.time_s) >= kShortestStep_s) {
    Record all = record;
    all.temperature_degC = temperature_degC;
    return all;
  }
  Record thin;
  thin.file = record.file;
  thin.hold = record.hold;
  for (std::size_t k = 0; k < record.size();) {
    const double end_s = record.time_s[k] + kShortestStep_s;
    double rows = 0.0, time_s = 0.0, current_A = 0.0, voltage_V = 0.0, sum_degC = 0.0;
    for (; k < record.size() && (rows == 0.0 || record.time_s[k] < end_s); ++k) {
      rows += 1.0;
      time_s += record.time_s[k];
      current_A += record.current_A[k];
      voltage_V += record.voltage_V[k];
      if (warm) sum_degC += temperature_degC[k];
    }
    thin.time_s.push_back(time_s / rows);
    thin.current_A.push_back(current_A / rows);
    thin.voltage_V.push_back(voltage_V / rows);
    if (warm) thin.temperature_degC.push_back(sum_degC / rows);
  }
  return thin;
}

std::size_t TrimUnplugging(Record& record) {
  std::size_t dropped = 0;
  while (dropped < kUnplugRows && record.size() > 10) {
    const std::size_t last = record.size() - 1;
    std::vector<double> before;
    for (std::size_t k = last - 5; k < last; ++k) before.push_back(record.voltage_V[k]);
    const double usual_V = Median(std::move(before));
    const bool fell = record.voltage_V[last] < (1.0 - kUnpluggedFall) * usual_V;
    if (!fell || record.current_A[last] > record.current_A[last - 1]) break;
    DropRows(record, {last});
    ++dropped;
  }
  return dropped;
}

using Windows = std::vector<std::pair<std::size_t, std::size_t>>;

Windows MakeWindows(const Record& record, const std::vector<std::size_t>& fresh, double window_s) {
  Windows windows;
  for (std::size_t f = 0; f < fresh.size();) {
    const double end_s = record.time_s[fresh[f]] + window_s;
    const std::size_t first = f++;
    while (f < fresh.size() && record.time_s[fresh[f]] < end_s) ++f;
    windows.emplace_back(first, f);
  }
  return windows;
}

struct Coherence {
  double correlation = 0.0;
  double resistance_Ohm = 0.0;
};

// How the changes of the voltage from window to window follow those of the current.
Coherence CoherenceAt(const Record& record,
                      const std::vector<std::size_t>& fresh,
                      const Windows& windows,
                      double lag_s) {
  Follower follow(record.time_s);
  double vv = 0.0, vi = 0.0, ii = 0.0;
  double before_V = 0.0, before_A = 0.0;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    double voltage_V = 0.0, current_A = 0.0;
    for (std::size_t f = windows[w].first; f < windows[w].second; ++f) {
      voltage_V += record.voltage_V[fresh[f]];
      const auto [row, share] = follow(record.time_s[fresh[f]] - lag_s);
      current_A += (1.0 - share) * record.current_A[row] + share * record.current_A[row + 1];
    }
    const auto rows = static_cast<double>(windows[w].second - windows[w].first);
    voltage_V /= rows;
    current_A /= rows;
    if (w > 0) {
      const double dv = voltage_V - before_V, di = current_A - before_A;
      vv += dv * dv;
      vi += dv * di;
      ii += di * di;
    }
    before_V = voltage_V;
    before_A = current_A;
  }
  if (!(vv > 0.0 && ii > 0.0)) return {};
  return {-vi / std::sqrt(vv * ii), std::max(0.0, -vi / ii)};
}

void ChooseWindows(FlightSamples& flight) {
  const Record& record = flight.record;
  const double row_s = MedianInterval(record.time_s);
  const double slower_s = std::max({flight.voltage_update_s, flight.current_update_s, row_s});
  const double step_s = std::clamp(0.25 * slower_s, 0.01, 0.1);
  double window_s = 0.0;
  Windows chosen;
  flight.coherence = 0.0;
  for (double try_s = 0.0; try_s <= kLongestWindow_s; try_s = std::max(slower_s, 2.0 * try_s)) {
    const Windows windows = MakeWindows(record, flight.fresh, try_s);
    if (windows.size() < 20) break;
    for (double lag_s = -kLargestLag_s; lag_s <= kLargestLag_s; lag_s += step_s) {
      const Coherence at = CoherenceAt(record, flight.fresh, windows, lag_s);
      // A longer window must be clearly better.
      constexpr double kClearlyCloser = 0.005;
      const bool same_window = try_s == window_s && !chosen.empty();
      if (at.correlation > flight.coherence + (same_window ? 0.0 : kClearlyCloser)) {
        flight.coherence = at.correlation;
        flight.lag_s = lag_s;
        flight.edge_resistance_Ohm = at.resistance_Ohm;
        window_s = try_s;
        chosen = windows;
      }
    }
    if (flight.coherence >= kCoherentEnough) break;
  }
  const double duration_s = record.time_s.back() - record.time_s.front();
  if (chosen.size() > kMostWindows || chosen.empty()) {
    window_s = std::max(window_s, duration_s / static_cast<double>(kMostWindows));
    chosen = MakeWindows(record, flight.fresh, window_s);
  }
  flight.window_s = window_s;
  flight.windows = std::move(chosen);
  flight.time_s.clear();
  flight.voltage_V.resize(static_cast<Eigen::Index>(flight.windows.size()));
  for (std::size_t w = 0; w < flight.windows.size(); ++w) {
    const auto [first, end] = flight.windows[w];
    double time_s = 0.0, voltage_V = 0.0;
    for (std::size_t f = first; f < end; ++f) {
      time_s += record.time_s[flight.fresh[f]];
      voltage_V += record.voltage_V[flight.fresh[f]];
    }
    flight.time_s.push_back(time_s / static_cast<double>(end - first));
    flight.voltage_V[static_cast<Eigen::Index>(w)] = voltage_V / static_cast<double>(end - first);
  }
}

// Rows of a voltage that stood still, but the first of each stretch, tell nothing; nor does any row at the end of the
// sensor's range.
void LeaveOutStuckVoltage(FlightSamples& flight) {
  const Record& record = flight.record;
  const Extent extent = FindExtent(record.voltage_V);
  for (const auto& [first, last] : FindStuckVoltage(flight)) {
    const double stuck_V = record.voltage_V[first];
    if (stuck_V == extent.least || stuck_V == extent.most) {
      std::erase_if(flight.fresh,
                    [&](std::size_t row) { return record.voltage_V[row] == stuck_V; });
    }
    std::erase_if(flight.fresh, [first = first, last = last](std::size_t row) {
      return row > first && row <= last;
    });
    flight.stuck_voltage_s += record.time_s[last] - record.time_s[first];
  }
  if (flight.stuck_voltage_s > 0.0) ChooseWindows(flight);
}

}  // namespace

void RefuseIdleFlight(const Record& record, double capacity_Ah) {
  constexpr double kShortest_s = 20.0;
  constexpr double kLeastCharge = 0.01;  // of the capacity
  constexpr double kLeastRate_per_h = 0.5;
  const SourcePosition position{record.file};
  if (record.voltage_V.empty() || record.size() < 2)
    throw LoadError(position,
                    "expected a flight with voltage and current, found less than two rows");
  const double length_s = record.time_s.back() - record.time_s.front();
  if (length_s < kShortest_s) {
    throw LoadError(
        position,
        fmt::format("expected a flight of at least {:g} s, found {:.3g} s: too short to "
                    "say anything of the pack",
                    kShortest_s,
                    length_s));
  }
  const Extent current_A = FindExtent(record.current_A);
  const double largest_A = std::max(0.0, current_A.most);
  const double charge_Ah = DeliveredCharge(record).back() / 3600.0;
  if (-charge_Ah >= kLeastCharge * capacity_Ah &&
      -current_A.least >= kLeastRate_per_h * capacity_Ah) {
    throw LoadError(
        position,
        fmt::format(
            "expected a flight that takes charge from its pack, found one that charges it by {:.3g} Ah, with up to "
            "{:.3g} A: a sensor that is wired backwards? Write it as a table and turn it (lipoid convert {} -o "
            "flight.csv; then read that with --current-sign discharge-negative)",
            -charge_Ah,
            -current_A.least,
            ForeignText(record.file)));
  }
  if (largest_A < kLeastRate_per_h * capacity_Ah || charge_Ah < kLeastCharge * capacity_Ah) {
    // A thousandth of the capacity, given in mAh, makes of an idle flight a usual one.
    constexpr double kMilli = 1e-3;
    constexpr double kMostRate_per_h = 50.0;
    const double as_Ah = kMilli * capacity_Ah;
    const bool in_mAh = largest_A >= kLeastRate_per_h * as_Ah &&
                        largest_A <= kMostRate_per_h * as_Ah && charge_Ah >= kLeastCharge * as_Ah;
    throw LoadError(
        position,
        fmt::format(
            "expected a flight that takes at least {:.3g} A and {:.3g} Ah from this pack of "
            "{:.3g} Ah, found {:.3g} A at most and {:.3g} Ah: {}",
            kLeastRate_per_h * capacity_Ah,
            kLeastCharge * capacity_Ah,
            capacity_Ah,
            largest_A,
            charge_Ah,
            in_mAh
                ? fmt::format(
                      "is the capacity in mAh, where Ah are expected? Of {:.3g} Ah these are what "
                      "a flight takes",
                      as_Ah)
                : "too idle to say anything of the pack"));
  }
  RefuseFlatVoltage(position, record);
  const double rows_s = length_s / static_cast<double>(record.size());
  constexpr double kSlowest_s = 5.0;
  if (rows_s > kSlowest_s) {
    throw LoadError(
        position,
        fmt::format("expected rows at most {:g} s apart, found one each {:.3g} s: loads "
                    "of a flight change faster",
                    kSlowest_s,
                    rows_s));
  }
}

std::vector<std::string> FlightSamples::Said() const {
  std::vector<std::string> said;
  if (coherence < kCoherent) {
    said.push_back(fmt::format(
        "voltage and current are not of the same instant, or the current hardly changes: their changes agree to "
        "{:.0f} % at best, over windows of {:.2g} s, so that fast drops are not resolved and the resistance may be too small",
        100.0 * coherence,
        window_s));
  }
  if (unfollowed_share > 0.0) {
    said.push_back(fmt::format(
        "the current wavers by {:.2g} % of its largest value from row to row, and the voltage does not follow: that is "
        "noise of the sensor or of other instants, and the current without it is taken to have flowed",
        100.0 * unfollowed_share));
  }
  if (stuck_voltage_s > 0.0) {
    said.push_back(fmt::format(
        "the voltage shows one value for {:.3g} s in all while the current moves: the sensor was stuck, and its rows "
        "are left out",
        stuck_voltage_s));
  }
  return said;
}

FlightSamples SampleFlight(const Log& log) {
  FlightSamples flight;
  flight.record = Thinned(log.record);
  Record& record = flight.record;
  flight.dropped_rows = TrimUnplugging(record);
  flight.voltage_update_s = UpdateInterval(record.time_s, record.voltage_V);
  flight.current_update_s = UpdateInterval(record.time_s, record.current_A);
  flight.largest_A = LargestMagnitude(record.current_A);
  for (const Gap& gap : FindGaps(record)) flight.gap_C += gap.unknown_C;
  flight.fresh = FreshRows(record.time_s, record.voltage_V, flight.voltage_update_s);
  ChooseWindows(flight);
  LeaveOutStuckVoltage(flight);
  flight.doubt = DoubtAboutStuckCurrent(flight);
  if (auto followed = TakeOutUnfollowed(flight)) {
    record.current_A = std::move(followed->current_A);
    flight.unfollowed_share = followed->noise_A / flight.largest_A;
    ChooseWindows(flight);
  }
  flight.unresolved = FindUnresolved(record, flight.current_update_s);
  return flight;
}

Eigen::MatrixXd FlightSamples::InWindows(const Eigen::MatrixXd& at_rows, double after_s) const {
  Eigen::MatrixXd in = Eigen::MatrixXd::Zero(voltage_V.size(), at_rows.cols());
  Follower follow(record.time_s);
  for (std::size_t w = 0; w < windows.size(); ++w) {
    const auto [first, end] = windows[w];
    auto sum = in.row(static_cast<Eigen::Index>(w));
    for (std::size_t f = first; f < end; ++f) {
      const auto [row, share] = follow(record.time_s[fresh[f]] - after_s);
      const auto at = static_cast<Eigen::Index>(row);
      sum += (1.0 - share) * at_rows.row(at) + share * at_rows.row(at + 1);
    }
    sum /= static_cast<double>(end - first);
  }
  return in;
}

Eigen::VectorXd FlightSamples::LagSlope(const Eigen::VectorXd& at_rows, double after_s) const {
  const double half_s = 0.5 * std::max(MedianInterval(record.time_s), 0.5 * window_s);
  return (InWindows(at_rows, after_s + half_s) - InWindows(at_rows, after_s - half_s)) /
         (2.0 * half_s);
}

FlightSamples::Errors FlightSamples::ErrorsOf(const Eigen::VectorXd& predicted_V,
                                              double after_s) const {
  Errors errors;
  Follower follow(record.time_s);
  for (const std::size_t measured : fresh) {
    const auto [row, share] = follow(record.time_s[measured] - after_s);
    const auto k = static_cast<Eigen::Index>(row);
    const double at_V = (1.0 - share) * predicted_V[k] + share * predicted_V[k + 1];
    const double percent = 100.0 * std::abs(at_V / record.voltage_V[measured] - 1.0);
    errors.mean_percent += percent / static_cast<double>(fresh.size());
    errors.max_percent = std::max(errors.max_percent, percent);
  }
  return errors;
}

}  // namespace lipoid
