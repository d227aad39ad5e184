#include "identify/logs/flight/flight_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "identify/logs/collector.h"
#include "identify/logs/flight/updates.h"
#include "model/core/counted.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// A pack that flies, whatever its size, has more; what is not connected floats below it.
constexpr double kLeastVoltage_V = 1.0;

// More than any pack that flies gives: what is left of a damaged message.
constexpr double kMostFlight_A = 2000.0;

// A pack in flight is charged by motors that brake, and never with more than it gives; what is less
// than this is not looked at.
constexpr double kLeastCharge_A = 10.0;

// A current that changes by so much moves the voltage of any real pack.
constexpr double kLoad_A = 1.0;

// A current of one row that is so many times the largest of all others, but for three and one in 200, is not
// believed where the voltage shows less than this share of what it shows of other currents.
constexpr double kFarBeyond = 4.0;
constexpr std::size_t kFew = 3;
constexpr std::size_t kOfRows = 200;
constexpr double kShown = 0.1;

std::string Described(const BatteryTrack& track) {
  std::string text = fmt::format("battery {} ({}", track.number, Counted(track.size(), "row"));
  if (track.size() > 0) {
    const auto [least, largest] =
        std::minmax_element(track.voltage_V.begin(), track.voltage_V.end(), [](double a, double b) {
          return !std::isnan(a) && (std::isnan(b) || a < b);  // NaN counts as largest
        });
    if (std::isfinite(*least) && std::isfinite(*largest))
      text += fmt::format(", {:.4g} V to {:.4g} V", *least, *largest);
  }
  return text + ")";
}

const BatteryTrack& Chosen(const SourcePosition& position,
                           const AutopilotFormat& format,
                           const AutopilotLog& flight,
                           const ReadOptions& options) {
  std::vector<const BatteryTrack*> with_rows;
  std::vector<std::string> listed;
  for (const BatteryTrack& track : flight.batteries) {
    if (track.size() > 0) with_rows.push_back(&track);
    listed.push_back(Described(track));
  }
  if (flight.batteries.empty()) {
    throw LoadError(position,
                    fmt::format("expected a battery in this {} log, found no message {}; the "
                                "autopilot did not log one",
                                format.name,
                                format.battery_message));
  }
  for (std::size_t k = 1; k < with_rows.size(); ++k) {
    if (with_rows[k]->number != with_rows[k - 1]->number) continue;
    throw LoadError(
        position,
        fmt::format(
            "expected one log, found {}: two logs were joined here; save each as a file of its own",
            fmt::join(listed, ", ")));
  }
  if (options.battery > 0) {
    for (const BatteryTrack& track : flight.batteries) {
      if (track.number == options.battery && track.size() > 0) return track;
    }
    throw LoadError(position,
                    fmt::format("expected rows of battery {} as the option battery says, found {}",
                                options.battery,
                                fmt::join(listed, ", ")));
  }
  if (with_rows.empty()) {
    throw LoadError(position,
                    fmt::format("expected rows of a battery, found {}", fmt::join(listed, ", ")));
  }
  if (with_rows.size() > 1) {
    throw LoadError(position,
                    fmt::format("expected one battery, found {}; say which with `battery` "
                                "(--battery {})",
                                fmt::join(listed, ", "),
                                with_rows.front()->number));
  }
  return *with_rows.front();
}

// The most rows whose times increase: one damaged time stamp costs its row and no other. Of rows
// with one time the first stays.
std::vector<std::size_t> RowsInOrder(const std::vector<double>& time_s,
                                     const std::vector<std::size_t>& rows) {
  std::vector<std::size_t> last;  // by length: the row that ends the longest run with least time
  std::vector<std::ptrdiff_t> before(rows.size(), -1);
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const auto place =
        std::lower_bound(last.begin(), last.end(), time_s[rows[k]], [&](std::size_t a, double t) {
          return time_s[rows[a]] < t;
        });
    if (place != last.begin()) before[k] = static_cast<std::ptrdiff_t>(*std::prev(place));
    if (place == last.end()) {
      last.push_back(k);
    } else if (time_s[rows[k]] < time_s[rows[*place]]) {
      *place = k;
    }
  }
  std::vector<std::size_t> kept;
  for (auto k = last.empty() ? std::ptrdiff_t{-1} : static_cast<std::ptrdiff_t>(last.back());
       k >= 0;
       k = before[static_cast<std::size_t>(k)])
    kept.push_back(rows[static_cast<std::size_t>(k)]);
  std::reverse(kept.begin(), kept.end());
  return kept;
}

// Rows of a track in their order whose current is what is left of a damaged message.
struct ImpossibleCurrents {
  // Alone, far beyond all others, and nothing of it in the voltage.
  std::vector<std::size_t> discharges;
  // Alone, with more than the pack ever gives.
  std::vector<std::size_t> charges;
};

// How much lower the voltage is in the quarter of the rows with the largest currents than in that with the
// least, over the current; 0 where the current hardly changes.
double ShownResistance(const BatteryTrack& track, std::vector<std::size_t> rows) {
  std::sort(rows.begin(), rows.end(), [&](std::size_t a, std::size_t b) {
    return track.current_A[a] < track.current_A[b];
  });
  const auto quarter = static_cast<std::ptrdiff_t>(rows.size() / 4);
  const auto difference = [&](const std::vector<double>& column) {
    const auto middle = [&](auto from) {
      std::vector<double> values;
      std::transform(
          from, from + quarter, std::back_inserter(values), [&](auto k) { return column[k]; });
      return Median(values);
    };
    return middle(rows.end() - quarter) - middle(rows.begin());
  };
  const double more_A = quarter > 0 ? difference(track.current_A) : 0.0;
  return more_A > kLoad_A ? -difference(track.voltage_V) / more_A : 0.0;
}

// None of a log that charges most of the time.
ImpossibleCurrents FindImpossible(const BatteryTrack& track, const std::vector<std::size_t>& rows) {
  std::vector<double> all;
  for (const std::size_t row : rows) all.push_back(track.current_A[row]);
  if (all.size() < 3 || Median(all) < 0.0) return {};
  const auto beside = [&](std::size_t k) {
    return std::pair{k > 0 ? k - 1 : k + 1, k + 1 < all.size() ? k + 1 : k - 1};
  };
  const double shown_Ohm = ShownResistance(track, rows);
  const auto is_silent = [&](std::size_t k) {
    const auto volts = [&](std::size_t of) { return track.voltage_V[rows[of]]; };
    const auto [before, after] = beside(k);
    const double sag_V =
        volts(before) - std::min(volts(k), volts(after));  // the voltage may lag by a row
    return sag_V < kShown * shown_Ohm * (all[k] - all[before]);
  };
  // Several messages may be damaged.
  std::vector<double> rising = all;
  std::sort(rising.begin(), rising.end());
  const std::size_t few = std::min(kFew + all.size() / kOfRows, all.size() - 1);
  const double usual_A = std::max(kLeastCharge_A, rising[all.size() - 1 - few]);
  ImpossibleCurrents found;
  double most_A = kLeastCharge_A;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto [before, after] = beside(k);
    if (all[k] > kFarBeyond * std::max({usual_A, all[before], all[after]}) && is_silent(k)) {
      found.discharges.push_back(rows[k]);
    } else {
      most_A = std::max(most_A, all[k]);
    }
  }
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto [before, after] = beside(k);
    if (all[k] < -most_A && all[before] >= -most_A && all[after] >= -most_A)
      found.charges.push_back(rows[k]);
  }
  return found;
}

void DropImpossible(const BatteryTrack& track, std::vector<std::size_t>& kept, LogReport& report) {
  const ImpossibleCurrents impossible = FindImpossible(track, kept);
  const auto drop = [&](const std::vector<std::size_t>& rows, std::string_view why) {
    if (rows.empty()) return;
    std::erase_if(
        kept, [&](std::size_t row) { return std::binary_search(rows.begin(), rows.end(), row); });
    report.dropped_unknown += rows.size();
    report.warnings.push_back(fmt::format(
        "{} dropped: a current of {:.4g} A at {:.10g} s{}, {}; a damaged message may hold it",
        Counted(rows.size(), "row"),
        track.current_A[rows[0]],
        track.time_s[rows[0]],
        rows.size() == 1 ? "" : ", the first of them",
        why));
  };
  drop(impossible.discharges,
       "which no other row comes near, and of which the voltage shows nothing");
  drop(impossible.charges, "with which the pack would be charged by more than it ever gives");
}

// Refuses what is no flight on a battery. Columns hold no NaN.
void CheckFlown(const SourcePosition& position, const Record& record) {
  const double high_V = *std::max_element(record.voltage_V.begin(), record.voltage_V.end());
  if (high_V < kLeastVoltage_V) {
    throw LoadError(
        position,
        fmt::format("expected the voltage of a battery, found at most {:.3g} V: none was "
                    "connected, or its voltage was not measured",
                    high_V));
  }
  RefuseFlatVoltage(position, record);
}

void NoteReading(const AutopilotLog& flight, LogReport& report) {
  if (flight.damaged_places > 0) {
    report.warnings.push_back(fmt::format(
        "{} bytes of damaged messages were passed over, in {}; reading went on at the next "
        "message that holds together",
        flight.skipped_bytes,
        Counted(flight.damaged_places, "place")));
  }
  if (flight.cut_last_message)
    report.notes.emplace_back("the log ends inside a message and was read to its last whole one");
  if (flight.dropouts > 0) {
    report.notes.push_back(fmt::format("the autopilot could not log for {:.3g} s in all, {}",
                                       flight.dropped_out_s,
                                       Counted(flight.dropouts, "time")));
  }
}

// What makes this other than a lab log, said before anyone fits it.
void NoteUpdates(const Record& record, FlightFacts& facts, LogReport& report) {
  facts.voltage_update_s = UpdateInterval(record.time_s, record.voltage_V);
  facts.current_update_s = UpdateInterval(record.time_s, record.current_A);
  const double row_s = MedianInterval(record.time_s);
  const double slower_s = std::max(facts.voltage_update_s, facts.current_update_s);
  if (slower_s > 1.5 * row_s) {
    report.notes.push_back(fmt::format(
        "rows come each {:.3g} s, but the voltage changes each {:.3g} s and the current "
        "each {:.3g} s: values are repeated until new ones come",
        row_s,
        facts.voltage_update_s,
        facts.current_update_s));
  }
}

}  // namespace

Log FlightLog(const std::string& file,
              const AutopilotFormat& format,
              AutopilotLog flight,
              const ReadOptions& options) {
  const SourcePosition position{file};
  if (!options.steps.empty() || !options.cycles.empty() || !options.columns.empty() ||
      !options.units.empty()) {
    throw LoadError(position,
                    fmt::format("expected a table because of the options steps, cycles, columns or "
                                "units, found a {} log, which names its own; leave them out",
                                format.name));
  }
  if (options.current_sign == "discharge-negative") {
    throw LoadError(
        position,
        fmt::format("expected discharge to be negative because of current_sign, found a {} "
                    "log, in which it is positive by definition; leave the option out",
                    format.name));
  }
  const BatteryTrack& track = Chosen(position, format, flight, options);
  Log log;
  LogReport& report = log.report;
  report.format = format.name;
  report.current_column = track.message;
  report.current_sign = "discharge-positive";
  report.current_sign_reason = fmt::format("discharge is positive in {} logs", format.name);

  std::vector<std::size_t> rows;
  std::size_t without_current = 0;
  for (std::size_t k = 0; k < track.size(); ++k) {
    const double t_s = track.time_s[k];
    if (t_s < options.start_s || t_s > options.end_s) {
      ++report.dropped_unselected;
      continue;
    }
    without_current += std::isfinite(track.current_A[k]) ? 0 : 1;
    const bool known = std::isfinite(track.current_A[k]) && std::isfinite(track.voltage_V[k]) &&
                       track.voltage_V[k] > 0.0 && std::abs(track.current_A[k]) <= kMostFlight_A;
    if (known) {
      rows.push_back(k);
    } else {
      ++report.dropped_unknown;
    }
  }
  if (rows.empty() && report.dropped_unknown == 0) {
    const auto [first, last] = std::minmax_element(track.time_s.begin(), track.time_s.end());
    throw LoadError(
        position,
        "expected rows within start_s and end_s as given, found none" + TimesOfLog(*first, *last));
  }
  if (rows.empty()) {
    throw LoadError(
        position,
        without_current == report.dropped_unknown
            ? fmt::format("expected a current, found none in the {} of battery {}: the "
                          "autopilot had no current sensor",
                          Counted(without_current, "row"),
                          track.number)
            : fmt::format("expected the voltage of a battery, found none in the {} of "
                          "battery {}: none was connected, or its voltage was not measured",
                          Counted(report.dropped_unknown, "row"),
                          track.number));
  }
  auto kept = RowsInOrder(track.time_s, rows);
  report.dropped_repeated_times = rows.size() - kept.size();
  DropImpossible(track, kept, report);

  Record& record = log.record;
  record.file = file;
  record.hold = options.hold;
  // 0 degC throughout, or none, is what autopilots write that have no thermometer.
  const bool has_temperature =
      std::all_of(kept.begin(),
                  kept.end(),
                  [&](std::size_t k) { return std::isfinite(track.temperature_degC[k]); }) &&
      std::any_of(kept.begin(), kept.end(), [&](std::size_t k) {
        return track.temperature_degC[k] != 0.0;
      });
  const double zero_s = options.ChoosesTimes() ? track.time_s[kept.front()] : 0.0;
  for (const std::size_t k : kept) {
    record.time_s.push_back(track.time_s[k] - zero_s);
    record.current_A.push_back(track.current_A[k]);
    record.voltage_V.push_back(track.voltage_V[k]);
    if (has_temperature) record.temperature_degC.push_back(track.temperature_degC[k]);
  }
  report.rows = record.size();
  CheckFlown(position, record);

  FlightFacts& facts = report.flight.emplace();
  facts.vehicle = flight.vehicle;
  facts.battery = track.number;
  facts.cells = track.cells;
  facts.capacity_Ah = track.capacity_Ah;
  for (const BatteryTrack& each : flight.batteries) facts.batteries.push_back(each.number);
  facts.messages = flight.messages;
  facts.skipped_bytes = flight.skipped_bytes;
  facts.damaged_places = flight.damaged_places;
  facts.cut_last_message = flight.cut_last_message;
  NoteReading(flight, report);
  NoteUpdates(record, facts, report);
  return log;
}

void RefuseFlatVoltage(const SourcePosition& position, const Record& record) {
  const auto [low_V, high_V] =
      std::minmax_element(record.voltage_V.begin(), record.voltage_V.end());
  const auto [low_A, high_A] =
      std::minmax_element(record.current_A.begin(), record.current_A.end());
  if (*low_V == *high_V && *high_A - *low_A > kLoad_A) {
    throw LoadError(
        position,
        fmt::format("expected a voltage that falls under load, found {:.4g} V throughout "
                    "while the current goes from {:.3g} A to {:.3g} A, as in a "
                    "simulation",
                    *low_V,
                    *low_A,
                    *high_A));
  }
}

}  // namespace lipoid
