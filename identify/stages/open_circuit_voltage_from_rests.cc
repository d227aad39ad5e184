#include "identify/stages/open_circuit_voltage_from_rests.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "identify/logs/columns.h"
#include "identify/logs/discharge.h"
#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kSameSoc = 0.005;  // rests closer than this tell the same point of the curve
constexpr int kNodesBelow = 8;      // the lowest rest: enough for a knee

// A rest and where it stands in its log.
struct Place {
  SettledRest rest;
  const LogOfRests* log = nullptr;
  std::size_t segment = 0;
};

struct Line {
  double value_V = 0.0;  // at the time asked for
  double slope_V_per_s = 0.0;
};

// The least-squares line through the rows [first, last] whose stamps lie in [from_s, to_s]; the
// mean of the rows where fewer than three do, the nearest row where none does.
Line FitLine(const Record& record, const Segment& rows, double from_s, double to_s, double at_s) {
  double n = 0.0;
  double t = 0.0;
  double v = 0.0;
  const auto visit = [&](auto&& take) {
    for (std::size_t k = rows.first; k <= rows.last; ++k) {
      if (record.time_s[k] >= from_s && record.time_s[k] <= to_s)
        take(record.time_s[k] - at_s, record.voltage_V[k]);
    }
  };
  visit([&](double time_s, double voltage_V) {
    n += 1.0;
    t += time_s;
    v += voltage_V;
  });
  if (n == 0.0) {
    const auto begin = record.time_s.begin() + static_cast<std::ptrdiff_t>(rows.first);
    const auto end = record.time_s.begin() + static_cast<std::ptrdiff_t>(rows.last);
    return {.value_V = record.voltage_V[static_cast<std::size_t>(
                std::lower_bound(begin, end, at_s) - record.time_s.begin())]};
  }
  t /= n;
  v /= n;
  double tt = 0.0;
  double tv = 0.0;
  visit([&](double time_s, double voltage_V) {
    tt += (time_s - t) * (time_s - t);
    tv += (time_s - t) * (voltage_V - v);
  });
  if (n < 3.0) return {.value_V = v};
  return {.value_V = v - tv / tt * t, .slope_V_per_s = tv / tt};
}

SettledRest Measure(const Record& record, const Segment& segment, double soc) {
  const double end_s = record.time_s[segment.last];
  const double rest_s = end_s - segment.start_s;
  const double middle_s = end_s - 0.5 * rest_s;
  const Line end = FitLine(record, segment, end_s - 0.25 * rest_s, end_s, end_s);
  const Line middle =
      FitLine(record, segment, middle_s - 0.125 * rest_s, middle_s + 0.125 * rest_s, middle_s);
  return {.soc = soc,
          .voltage_V = end.value_V,
          .rest_s = rest_s,
          .drift_V = end.value_V - middle.value_V,
          .slope_V_per_s = end.slope_V_per_s};
}

std::vector<Place> FindRests(const std::vector<LogOfRests>& logs, double alpha_C) {
  std::vector<Place> places;
  for (const LogOfRests& log : logs) {
    double delivered_C = 0.0;  // before the segment
    for (std::size_t s = 0; s < log.segments->size(); ++s) {
      const Segment& segment = (*log.segments)[s];
      delivered_C += segment.charge_C;  // what leaks at "rest" has left at its end
      const bool settled = s == 0 || segment.duration_s() >= kShortestRest_s;
      if (segment.kind != SegmentKind::kRest || !settled) continue;
      const double soc = log.initial_soc - delivered_C / alpha_C;  // (4.59)
      places.push_back({.rest = Measure(*log.record, segment, soc), .log = &log, .segment = s});
    }
  }
  std::stable_sort(places.begin(), places.end(), [](const Place& a, const Place& b) {
    return a.rest.soc < b.rest.soc;
  });
  return places;
}

// One rest of those at nearly one state of charge, the longest; and of two that fall with the state
// of charge, the one that had settled more.
std::vector<Place> KeepRising(const std::vector<Place>& places) {
  std::vector<Place> kept;
  for (const Place& place : places) {
    bool keep = true;
    while (keep && !kept.empty()) {
      const SettledRest& before = kept.back().rest;
      const bool same = place.rest.soc - before.soc < kSameSoc;
      const bool rises = place.rest.voltage_V > before.voltage_V;
      if (!same && rises) break;
      const bool better = same ? place.rest.rest_s > before.rest_s
                               : std::abs(place.rest.drift_V) < std::abs(before.drift_V);
      if (better) {
        kept.pop_back();
      } else {
        keep = false;
      }
    }
    if (keep) kept.push_back(place);
  }
  return kept;
}

// Below the lowest rest, to the end of the load behind it: nodes from there downwards are put into
// `soc` and `voltage_V`. Fewer of them where the two guesses do not yet part.
void GuessBelow(const std::vector<Place>& rising,
                double alpha_C,
                OcvFromRests& result,
                std::vector<double>& soc,
                std::vector<double>& voltage_V) {
  const Place& lowest = rising[0];
  const SettledRest& rest = lowest.rest;
  const auto& segments = *lowest.log->segments;
  const Record& record = *lowest.log->record;
  if (lowest.segment == 0 || lowest.segment + 1 >= segments.size()) return;
  const Segment& before = segments[lowest.segment - 1];
  const Segment& load = segments[lowest.segment + 1];
  if (!(before.current_A > 0.0 && load.current_A > 0.0)) return;
  const double drop_V =
      (rest.voltage_V - record.voltage_V[before.last]) * load.current_A / before.current_A;
  const double slope_V =
      (rising[1].rest.voltage_V - rest.voltage_V) / (rising[1].rest.soc - rest.soc);
  if (!(drop_V > 0.0)) return;
  double lowest_V = rest.voltage_V;
  double moved_C = 0.0;
  std::size_t row = segments[lowest.segment].last;
  for (int k = 1; k <= kNodesBelow; ++k) {
    const double wanted_C = load.charge_C * k / double(kNodesBelow);
    while (row < load.last && (row < load.first || moved_C < wanted_C)) {
      const double current_A = record.current_A[record.hold == Hold::kBackward ? row + 1 : row];
      moved_C += current_A * (record.time_s[row + 1] - record.time_s[row]);  // (4.59)
      ++row;
    }
    const double above_V = rest.voltage_V - slope_V * moved_C / alpha_C;
    const double below_V = std::min(above_V, record.voltage_V[row] + drop_V);
    const double middle_V = 0.5 * (above_V + below_V);
    if (!(middle_V < lowest_V)) continue;
    lowest_V = middle_V;
    soc.push_back(rest.soc - moved_C / alpha_C);
    voltage_V.push_back(middle_V);
    result.guessed_to_soc = soc.back();
    result.half_gap_V = 0.5 * (above_V - below_V);
    result.drop_V = drop_V;
  }
}

}  // namespace

OcvFromRests FindOpenCircuitVoltageFromRests(const std::vector<LogOfRests>& logs, double alpha_C) {
  Require(alpha_C > 0.0, "alpha_C > 0", {{"alpha_C", alpha_C}});
  Require(!logs.empty(), "logs of pulses, at least one", {});
  const std::vector<Place> places = KeepRising(FindRests(logs, alpha_C));
  if (places.size() < kFewestRests) {
    throw LoadError(
        {logs.front().record->file},
        fmt::format("expected rests of at least {:.0f} s at {} or more states of charge, from "
                    "which the open-circuit voltage follows where there is no low-rate log, found "
                    "{} (the rested start counts as one); add a low-rate log, or give the curve "
                    "with --open-circuit-voltage FILE",
                    kShortestRest_s,
                    kFewestRests,
                    places.size()));
  }
  OcvFromRests result;
  std::vector<double> soc;
  std::vector<double> voltage_V;
  GuessBelow(places, alpha_C, result, soc, voltage_V);
  std::reverse(soc.begin(), soc.end());
  std::reverse(voltage_V.begin(), voltage_V.end());
  for (const Place& place : places) {
    result.rests.push_back(place.rest);
    result.largest_drift_V = std::max(result.largest_drift_V, std::abs(place.rest.drift_V));
    soc.push_back(place.rest.soc);
    voltage_V.push_back(place.rest.voltage_V);
  }
  result.curve = OpenCircuitVoltage::Linear(std::move(soc), std::move(voltage_V));
  return result;
}

std::string InWords(const OcvFromRests& result) {
  std::string text = fmt::format(
      "v_oc(A) joins the voltages at the end of {} rests of the pulses by straight lines, from A = "
      "{:.3f} to {:.3f}; in the second half of a rest the voltage still moved by up to {:.2g} mV, "
      "and v_oc may be off by as much",
      result.rests.size(),
      result.rests.front().soc,
      result.rests.back().soc,
      1e3 * result.largest_drift_V);
  if (result.guessed_to_soc) {
    text += fmt::format(
        "; from there down to A = {:.3f} it is a guess from the voltage under load, good to {:.0f} "
        "mV at its end",
        std::round(1e3 * *result.guessed_to_soc) / 1e3 + 0.0,  // no minus before a zero
        1e3 * std::max(result.half_gap_V, result.largest_drift_V));
  }
  return text;
}

std::optional<double> ChargeToCutoff(const std::vector<LogOfRests>& logs, double cutoff_V) {
  std::optional<double> most_C;
  for (const LogOfRests& log : logs) {
    const auto& voltage_V = log.record->voltage_V;
    const auto end = std::find_if(voltage_V.begin(), voltage_V.end(), [&](double v) {
      return v <= cutoff_V + kCutoffTolerance_V;
    });
    if (end == voltage_V.end()) continue;
    const auto row = static_cast<std::size_t>(end - voltage_V.begin());
    const double charge_C = CountCharge(*log.record, 0, row).charge_C / log.initial_soc;
    if (charge_C > most_C.value_or(0.0)) most_C = charge_C;
  }
  return most_C;
}

std::optional<AlphaOfRests> FindAlphaOfRests(const std::vector<LogOfRests>& logs,
                                             const OpenCircuitVoltage& curve) {
  constexpr double kDeepEnough = 0.5;
  const double empty_V = curve(curve.soc_lo());
  const double full_V = curve(curve.soc_hi());
  std::vector<std::pair<double, double>> taken;  // by the curve, and in C
  double xx = 0.0;
  double xq = 0.0;
  double x_drift = 0.0;
  double deepest = 0.0;
  for (const auto& [rest, log, segment] : FindRests(logs, 1.0)) {
    const double charge_C = log->initial_soc - rest.soc;  // over an alpha of 1 C
    if (!(charge_C > 0.0) || rest.voltage_V < empty_V || rest.voltage_V > full_V) continue;
    const double soc = curve.SocAtVoltage(rest.voltage_V);
    const double x = log->initial_soc - soc;  // (4.59)
    if (!(x > 0.0)) continue;
    taken.emplace_back(x, charge_C);
    xx += x * x;
    xq += x * charge_C;
    x_drift += x * std::abs(curve.SocAtVoltage(rest.voltage_V + rest.drift_V) - soc);
    deepest = std::max(deepest, x);
  }
  if (taken.size() < kFewestRests || deepest < kDeepEnough) return std::nullopt;
  const double alpha_C = xq / xx;
  double square = 0.0;
  for (const auto& [x, charge_C] : taken)
    square += (x - charge_C / alpha_C) * (x - charge_C / alpha_C);
  const auto n = static_cast<double>(taken.size());
  const double scatter = std::sqrt(square / (n - 1.0) / (xx / n));
  return AlphaOfRests{.alpha_C = alpha_C,
                      .error_C = alpha_C * std::hypot(scatter, x_drift / xx),
                      .rests = taken.size()};
}

}  // namespace lipoid
