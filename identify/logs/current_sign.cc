#include "identify/logs/current_sign.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "identify/logs/columns.h"
#include "identify/median.h"

namespace lipoid {
namespace {

// Shares of the largest current: below the first a row is at rest, above the second a change is an
// edge.
constexpr double kRestShare = 0.02;
constexpr double kEdgeShare = 0.1;

// Agreement of evidence with itself, from -1 to 1: sum of signed over sum of absolute
// contributions.
constexpr double kDecisive = 0.7;
constexpr double kIncoherent = 0.3;

// Multiples of the noise that count as seen; multiples of the trend before an edge that make it an
// edge.
constexpr double kSeen = 5.0;
constexpr double kAboveTrend = 2.0;

// Scatter of the voltage about a straight line through neighbouring rows of equal current, and
// never less than half the resolution.
double VoltageNoise(const Record& record, double largest_A) {
  std::vector<double> bends;
  bends.reserve(record.size());
  double resolution_V = 1e-3;
  const auto same_current = [&](std::size_t k) {
    return std::abs(record.current_A[k] - record.current_A[k - 1]) <= kRestShare * largest_A;
  };
  for (std::size_t k = 2; k < record.size(); ++k) {
    if (!same_current(k) || !same_current(k - 1)) continue;
    const double before_V = record.voltage_V[k - 1] - record.voltage_V[k - 2];
    const double after_V = record.voltage_V[k] - record.voltage_V[k - 1];
    bends.push_back(std::abs(after_V - before_V));
    if (after_V != 0.0) resolution_V = std::min(resolution_V, std::abs(after_V));
  }
  constexpr double kMedianOfBend = 1.65;  // of |a - 2 b + c| for unit normal scatter: 0.674 sqrt(6)
  constexpr double kUnknown_V = 2e-3;     // no three rows of one current
  if (bends.empty()) return kUnknown_V;
  constexpr std::size_t kEnoughBends = 6;  // fewer are as likely the shape of the curve
  const double most_V = bends.size() < kEnoughBends ? kUnknown_V : 1e3;
  return std::max(
      {std::min(UpperMedian(std::move(bends)) / kMedianOfBend, most_V), resolution_V / 2, 1e-7});
}

struct Evidence {
  double sum = 0.0;  // signed: positive says that discharge is positive
  double absolute = 0.0;
  std::size_t count = 0;

  void Add(double contribution) {
    sum += contribution;
    absolute += std::abs(contribution);
    ++count;
  }
  [[nodiscard]] double Agreement() const { return absolute > 0.0 ? sum / absolute : 0.0; }
};

struct Edges {
  Evidence evidence;            // of the edges that are large against the largest current
  double resistance_Ohm = 0.0;  // of those, signed as the evidence
  // -dv/di of all edges, small ones too.
  std::vector<double> each_Ohm;
  double largest_V = 0.0;
  std::size_t after_calm = 0;  // edges before which the voltage was seen to keep still
};

Edges LookAtEdges(const Record& record, double largest_A, double noise_V) {
  std::vector<double> intervals_s;
  intervals_s.reserve(record.size());
  for (std::size_t k = 1; k < record.size(); ++k)
    intervals_s.push_back(record.time_s[k] - record.time_s[k - 1]);
  // Across a gap the voltage moves for reasons that are not in the log.
  const double longest_s = std::max(60.0, 20.0 * UpperMedian(std::move(intervals_s)));
  Edges edges;
  double squares = 0.0;
  double products = 0.0;
  for (std::size_t k = 1; k < record.size(); ++k) {
    const double di_A = record.current_A[k] - record.current_A[k - 1];
    if (std::abs(di_A) < kRestShare * largest_A) continue;
    const double dt_s = record.time_s[k] - record.time_s[k - 1];
    const double dv_V = record.voltage_V[k] - record.voltage_V[k - 1];
    if (std::abs(dv_V) < kSeen * noise_V || dt_s > longest_s) continue;
    if (k > 1) {  // what the voltage was doing anyway must not pass for the edge
      const double before_V = record.voltage_V[k - 1] - record.voltage_V[k - 2];
      const double before_s = record.time_s[k - 1] - record.time_s[k - 2];
      const double before_A = record.current_A[k - 1] - record.current_A[k - 2];
      const double going_on_V =
          std::abs(before_A) < kRestShare * largest_A ? before_V / before_s * dt_s : 0.0;
      if (std::abs(dv_V) < kAboveTrend * std::abs(going_on_V)) continue;
      edges.after_calm += std::abs(before_A) < kRestShare * largest_A ? 1 : 0;
    }
    edges.each_Ohm.push_back(-dv_V / di_A);
    edges.largest_V = std::max(edges.largest_V, std::abs(dv_V));
    if (std::abs(di_A) < kEdgeShare * largest_A) continue;
    edges.evidence.Add(-dv_V * di_A);
    products -= dv_V * di_A;
    squares += di_A * di_A;
  }
  if (squares > 0.0) edges.resistance_Ohm = products / squares;
  return edges;
}

// What the voltage did over one stretch of current of one sign.
struct Stretch {
  double charge_C = 0.0;  // absolute
  double fall_V = 0.0;    // first minus last, times the sign of the current
  double range_V = 0.0;
  double current_range_A = 0.0;
  double first_half_V = 0.0;    // fall over the first half of the charge
  double last_quarter_V = 0.0;  // and over its last quarter
  double against_V = 0.0;       // largest move against the fall, without the ohmic part
};

Stretch LookAtStretch(const Record& record,
                      std::size_t first,
                      std::size_t last,
                      double resistance_Ohm) {
  const double sign = record.current_A[first] > 0.0 ? 1.0 : -1.0;
  Stretch stretch;
  for (std::size_t k = first + 1; k <= last; ++k) {
    stretch.charge_C += std::abs(record.current_A[k]) * (record.time_s[k] - record.time_s[k - 1]);
  }
  const auto v = [&](std::size_t k) { return record.voltage_V[k]; };
  const auto [low, high] =
      std::minmax_element(record.voltage_V.begin() + static_cast<std::ptrdiff_t>(first),
                          record.voltage_V.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  stretch.range_V = *high - *low;
  const auto [least, most] =
      std::minmax_element(record.current_A.begin() + static_cast<std::ptrdiff_t>(first),
                          record.current_A.begin() + static_cast<std::ptrdiff_t>(last) + 1);
  stretch.current_range_A = *most - *least;
  stretch.fall_V = sign * (v(first) - v(last));

  const double direction = stretch.fall_V >= 0.0 ? sign : -sign;  // of the fall in terms of v
  double charge_C = 0.0;
  bool half_is_set = false;
  bool quarter_is_set = false;
  double extreme_V = v(first) + resistance_Ohm * record.current_A[first];
  for (std::size_t k = first + 1; k <= last; ++k) {
    charge_C += std::abs(record.current_A[k]) * (record.time_s[k] - record.time_s[k - 1]);
    if (!half_is_set && charge_C >= 0.5 * stretch.charge_C) {
      stretch.first_half_V = sign * (v(first) - v(k));
      half_is_set = true;
    }
    if (!quarter_is_set && charge_C >= 0.75 * stretch.charge_C) {
      stretch.last_quarter_V = sign * (v(k) - v(last));
      quarter_is_set = true;
    }
    const double u_V = v(k) + resistance_Ohm * record.current_A[k];
    extreme_V = direction > 0.0 ? std::min(extreme_V, u_V) : std::max(extreme_V, u_V);
    stretch.against_V = std::max(stretch.against_V, std::abs(u_V - extreme_V));
  }
  return stretch;
}

std::vector<Stretch> LookAtStretches(const Record& record,
                                     double largest_A,
                                     double resistance_Ohm) {
  std::vector<Stretch> stretches;
  const double rest_A = kRestShare * largest_A;
  const auto side = [&](std::size_t k) {
    const double i_A = record.current_A[k];
    return i_A > rest_A ? 1 : i_A < -rest_A ? -1 : 0;
  };
  for (std::size_t first = 0; first < record.size();) {
    std::size_t next = first + 1;
    while (next < record.size() && side(next) == side(first)) ++next;
    if (side(first) != 0 && next - first > 1) {
      stretches.push_back(LookAtStretch(record, first, next - 1, resistance_Ohm));
    }
    first = next;
  }
  return stretches;
}

// Edges that go the other way than the large ones. Recovery from an earlier load can turn a small
// edge, but not often, and not by as much as the resistance would.
bool HasContraryEdges(const Edges& edges, double side) {
  constexpr double kFew = 0.1;
  constexpr double kAsMuch = 0.7;
  const auto contrary = std::count_if(edges.each_Ohm.begin(),
                                      edges.each_Ohm.end(),
                                      [&](double r_Ohm) { return side * r_Ohm < 0.0; });
  const bool strong = std::any_of(edges.each_Ohm.begin(), edges.each_Ohm.end(), [&](double r_Ohm) {
    return side * r_Ohm < -kAsMuch * std::abs(edges.resistance_Ohm);
  });
  return static_cast<double>(contrary) > kFew * static_cast<double>(edges.each_Ohm.size()) &&
         (contrary > 1 || strong);
}

// Every n-th row of a long log: what a slower logger would have written says as much about the
// sign.
Record Thinned(const Record& record) {
  constexpr std::size_t kEnoughRows = std::size_t{1} << 17;
  const std::size_t stride = record.size() / kEnoughRows + 1;
  Record thin;
  for (auto* column : {&thin.time_s, &thin.current_A, &thin.voltage_V})
    column->reserve(record.size() / stride + 1);
  for (std::size_t k = 0; k < record.size(); k += stride) {
    thin.time_s.push_back(record.time_s[k]);
    thin.current_A.push_back(record.current_A[k]);
    thin.voltage_V.push_back(record.voltage_V[k]);
  }
  return thin;
}

std::string_view RisesOrFalls(bool falls) { return falls ? "falls" : "rises"; }

}  // namespace

SignFinding FindSignFromPhysics(const Record& whole) {
  const Record record = Thinned(whole);
  const double largest_A = LargestMagnitude(record.current_A);
  if (largest_A == 0.0) return {CurrentSign::kUnclear, "no current flows"};
  const double noise_V = VoltageNoise(record, largest_A);
  const Edges edges = LookAtEdges(record, largest_A, noise_V);
  const auto stretches = LookAtStretches(record, largest_A, edges.resistance_Ohm);

  Evidence flow;
  double charge_C = 0.0;
  double fall_V = 0.0;
  for (const Stretch& stretch : stretches) {
    charge_C += stretch.charge_C;
    if (stretch.range_V < kSeen * noise_V) continue;
    // Weighted by the charge and by how far the voltage moved.
    flow.absolute += stretch.charge_C * stretch.range_V;
    flow.sum += stretch.charge_C * stretch.fall_V;
    fall_V += stretch.fall_V;
    ++flow.count;
  }
  const bool has_edges = edges.evidence.count > 0;
  const bool has_flow = flow.count > 0;
  const double by_edges = edges.evidence.Agreement();
  const double by_flow = flow.Agreement();
  if (!has_edges && !has_flow) {
    return {CurrentSign::kUnclear, "the voltage hardly moves with the current"};
  }

  constexpr double kAlone = 4.0;
  if (!has_flow && edges.evidence.count == 1 && edges.largest_V < kAlone * kSeen * noise_V) {
    return {CurrentSign::kUnclear,
            "the voltage hardly moves with the one switching of the current"};
  }

  const double best = std::abs(by_edges) >= std::abs(by_flow) ? by_edges : by_flow;
  const bool falls = best > 0.0;
  const double side = falls ? 1.0 : -1.0;
  const auto against = [&](bool has, double agreement) {
    return has && side * agreement < kIncoherent;
  };
  if (std::abs(best) < kDecisive || against(has_edges, by_edges) || against(has_flow, by_flow)) {
    return {CurrentSign::kUnclear,
            "the voltage falls with the current in some places and rises in others, as if the "
            "current had no sign"};
  }

  // A current that never changes sign may be the amount alone, of charging as well as discharging.
  const auto [low, high] = std::minmax_element(record.current_A.begin(), record.current_A.end());
  const bool one_sided = *low >= -kRestShare * largest_A || *high <= kRestShare * largest_A;
  if (one_sided && HasContraryEdges(edges, side)) {
    return {CurrentSign::kUnclear,
            "the current has one sign but the voltage falls at some of its edges and rises at "
            "others, as if it had no "
            "sign"};
  }
  for (const Stretch& stretch : stretches) {
    constexpr double kShareOfCharge = 0.02;
    if (!one_sided || stretch.charge_C < kShareOfCharge * charge_C) continue;
    // Held at a voltage while the current changes: the end of a charge, or of a discharge.
    const double ohmic_V = std::abs(edges.resistance_Ohm) * stretch.current_range_A;
    if (ohmic_V > 2 * kSeen * noise_V && stretch.range_V < 0.3 * ohmic_V) {
      return {CurrentSign::kUnclear,
              "the current has one sign and in places the voltage is held while it changes, as at "
              "the end of a charge"};
    }
    if (stretch.range_V < 2 * kSeen * noise_V) continue;
    // Recovery from an earlier load also goes the other way, but slows down: it is over in the
    // second half.
    const double second_half_V = side * (stretch.fall_V - stretch.first_half_V);
    const bool turned =
        second_half_V < -std::max(0.3 * std::abs(stretch.first_half_V), 2 * kSeen * noise_V);
    const bool there_and_back = stretch.against_V > 0.25 * stretch.range_V &&
                                side * stretch.last_quarter_V < -0.2 * stretch.range_V;
    const bool many_times = stretch.against_V > 0.6 * stretch.range_V &&
                            stretch.against_V > 2 * kSeen * noise_V && side * stretch.fall_V > 0.0;
    if (turned || there_and_back || many_times) {
      return {CurrentSign::kUnclear,
              "the current has one sign but the voltage both falls and rises while it flows, as if "
              "it had no sign"};
    }
  }

  if (edges.after_calm == 0) {
    // Where the log does not show what was before the current, a recovery from an earlier load
    // could pose as the opposite current. A recovery slows down; a discharge goes far, or on and
    // on, or its edge stands out.
    constexpr double kFar_V = 0.05;
    constexpr double kFarShare = 0.03;
    constexpr double kOn_V = 0.015;
    constexpr double kOnAndOn = 0.8;
    double mean_V = 0.0;
    for (const double v : record.voltage_V)
      mean_V += std::abs(v) / static_cast<double>(record.size());
    const bool far = std::abs(fall_V) > std::max(kFarShare * mean_V, kFar_V);
    const bool on_and_on =
        std::abs(fall_V) > std::max(kOn_V, 2 * noise_V) &&
        std::all_of(stretches.begin(), stretches.end(), [&](const Stretch& stretch) {
          return side * (stretch.fall_V - stretch.first_half_V) >=
                 kOnAndOn * side * stretch.first_half_V;
        });
    const bool stands_out = has_edges && std::abs(fall_V) < 2.0 * edges.largest_V;
    if (!far && !on_and_on && !stands_out) {
      return {CurrentSign::kUnclear,
              "the log holds no clear switching of the current and the voltage hardly moves"};
    }
  }

  std::string reason = "the voltage ";
  if (has_edges) {
    reason += fmt::format("{} where the current rises ({} edges, {:.3g} Ohm)",
                          RisesOrFalls(falls),
                          edges.evidence.count,
                          std::abs(edges.resistance_Ohm));
  }
  if (has_flow) {
    reason += fmt::format("{}{} while positive current flows ({:.3g} V in all)",
                          has_edges ? " and " : "",
                          RisesOrFalls(falls),
                          std::abs(fall_V));
  }
  return {falls ? CurrentSign::kDischargePositive : CurrentSign::kDischargeNegative, reason};
}

SignFinding FindSignFromStates(const Record& record, const std::vector<std::int8_t>& directions) {
  if (directions.size() != record.size())
    return {CurrentSign::kUnclear, "the log has no state column"};
  const double largest_A = LargestMagnitude(record.current_A);
  if (largest_A == 0.0) {
    const bool any =
        std::any_of(directions.begin(), directions.end(), [](auto d) { return d != 0; });
    if (any)
      return {CurrentSign::kUnclear,
              "the state column says charge or discharge but no current flows"};
    return {CurrentSign::kUnsigned,
            "no current flows, and the state column says neither charge nor discharge"};
  }
  // Rows of each state with a positive and with a negative current.
  std::size_t discharge[2] = {0, 0};
  std::size_t charge[2] = {0, 0};
  std::size_t neither[2] = {0, 0};
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (std::abs(record.current_A[k]) < kRestShare * largest_A) continue;
    auto& count = directions[k] > 0 ? discharge : directions[k] < 0 ? charge : neither;
    ++count[record.current_A[k] > 0.0 ? 0 : 1];
  }
  const auto total = [](const std::size_t(&count)[2]) { return count[0] + count[1]; };
  if (total(discharge) + total(charge) == 0) {
    return {CurrentSign::kUnclear,
            "the state column says neither charge nor discharge where current flows"};
  }
  // A row at a change of step may still carry the state of the step before.
  const auto mostly = [&](const std::size_t(&count)[2], int which) {
    constexpr double kMost = 0.98;
    return static_cast<double>(count[which]) >= kMost * static_cast<double>(total(count));
  };
  const auto describe = [](std::string_view what, const std::size_t(&count)[2]) {
    return fmt::format("{} where the current is {} ({} rows)",
                       what,
                       count[0] >= count[1] ? "positive" : "negative",
                       std::max(count[0], count[1]));
  };
  std::string reason = "the state column says ";
  if (total(discharge) > 0) reason += describe("discharge", discharge);
  if (total(charge) > 0)
    reason += (total(discharge) > 0 ? " and " : "") + describe("charge", charge);
  for (const int sign : {0, 1}) {
    if (!mostly(discharge, sign) || !mostly(charge, 1 - sign)) continue;
    return {sign == 0 ? CurrentSign::kDischargePositive : CurrentSign::kDischargeNegative, reason};
  }
  for (const int sign : {0, 1}) {
    if (!mostly(discharge, sign) || !mostly(charge, sign)) continue;
    if (total(neither) > 0) {
      return {CurrentSign::kUnclear,
              fmt::format("the current has no sign of its own, and in {} rows with current the "
                          "state column says "
                          "neither charge nor discharge",
                          total(neither))};
    }
    return {CurrentSign::kUnsigned, reason};
  }
  return {CurrentSign::kUnclear,
          "the state column and the sign of the current contradict each other"};
}

}  // namespace lipoid
