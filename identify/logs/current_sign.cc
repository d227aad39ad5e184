#include "identify/logs/current_sign.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string_view>

#include "identify/logs/columns.h"
#include "identify/median.h"

namespace lipoid {
namespace {

// What speaks for a sign is a log-likelihood ratio in nats, above 0 for "discharge is positive".
// All evidence so has one unit and adds up:
//
//   edges   sum of ln(1 + (dv/s)^2) - ln(1 + ((dv + R di)/s)^2): how much better a resistance R
//           explains the edges of the current than none does. The tails are heavy because a single
//           edge may be turned by a recovery or by a row that was written late. s is the noise of
//           the voltage and what the voltage was doing anyway.
//   flow    6 (E_+ - E_-) / d^2: E_+ is the variance of the voltage, weighted by charge, that a
//           cell with a resistance and a falling open-circuit voltage explains if discharge is
//           positive, E_- the same if it is negative. An even fall by F volts has the variance
//           F^2 / 12 and so gives F^2 / (2 d^2). d is what a voltage moves by for other reasons: a
//           recovery from an earlier load, warming, and what such a simple cell misses.
//
// A sign is found where the sum is decisive and little stands against it.
constexpr double kDecisive = 9.0;  // odds of 8000 to 1
// What may stand against a sign: this, and a share of what speaks for it.
constexpr double kAgainst = 2.0;
constexpr double kAgainstShare = 0.25;
// A current that never changes sign may be an amount, of charging as well as of discharging: then
// a few places that say the opposite are enough.
constexpr double kAgainstShareOfAmount = 0.02;

// Shares of the largest current: below the first a row is at rest, and no noise hides a change
// above the second.
constexpr double kRestShare = 0.02;
constexpr double kHiddenShare = 0.3;
// Multiples of its noise by which a current must change: of 10,000 rows of noise none does.
constexpr double kBeyondNoise = 7.0;

// What a voltage moves by on its own, as shares of it: 50 mV and 15 mV of 3.8 V. A move that slows
// down may be a recovery from an earlier load; one that keeps up is hardly that.
constexpr double kDrift = 0.013;
constexpr double kSteadyDrift = 0.004;

double Odds(double multiple_of_scale) { return std::log1p(multiple_of_scale * multiple_of_scale); }

// A quantile of |a - 2 b + c| over `unit(k)`, which is 0 for rows that do not count. Slow moves
// hardly show in it. None where there are so few rows that the shape of the curve might be all
// there is.
template <class Unit>
std::optional<double> BendQuantile(const std::vector<double>& column,
                                   double quantile,
                                   const Unit& unit) {
  std::vector<double> bends;
  bends.reserve(column.size());
  for (std::size_t k = 2; k < column.size(); ++k) {
    const double one = unit(k);
    if (one > 0.0) bends.push_back(std::abs(column[k] - 2.0 * column[k - 1] + column[k - 2]) / one);
  }
  constexpr std::size_t kEnough = 6;
  if (bends.size() < kEnough) return std::nullopt;
  const auto at =
      bends.begin() + static_cast<std::ptrdiff_t>(quantile * static_cast<double>(bends.size()));
  std::nth_element(bends.begin(), at, bends.end());
  return *at;
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

// The record, and what can be said of it without a sign.
struct Look {
  const Record& record;
  double largest_A = 0.0;
  double least_A = 0.0;    // a smaller current is a rest, a smaller change of it no edge
  double noise_A = 0.0;    // of one row
  double noise_share = 0.0;  // the same as a share of its current
  double noise_V = 0.0;    // of one row, at least half the resolution
  double longest_s = 0.0;  // across longer intervals the voltage moves for reasons not in the log
  double mean_V = 0.0;
  bool one_sided = false;  // the current never changes sign

  [[nodiscard]] double di_A(std::size_t k) const {
    return record.current_A[k] - record.current_A[k - 1];
  }
  [[nodiscard]] double dv_V(std::size_t k) const {
    return record.voltage_V[k] - record.voltage_V[k - 1];
  }
  [[nodiscard]] double dt_s(std::size_t k) const { return record.time_s[k] - record.time_s[k - 1]; }
  // Whether the current changes by more than its noise.
  [[nodiscard]] bool Changes(std::size_t k) const {
    const double of_reading_A =
        kBeyondNoise * noise_share *
        std::max(std::abs(record.current_A[k]), std::abs(record.current_A[k - 1]));
    return std::abs(di_A(k)) >=
           std::max(least_A, std::min(of_reading_A, kHiddenShare * largest_A));
  }
  [[nodiscard]] bool Calm(std::size_t k) const { return !Changes(k) && dt_s(k) <= longest_s; }
  [[nodiscard]] bool Loaded(std::size_t k) const {
    return std::abs(record.current_A[k]) > least_A;
  }
  [[nodiscard]] double drift_V(double share) const {
    return std::hypot(share * mean_V, 2.0 * noise_V);
  }
};

Look LookAt(const Record& record, double largest_A) {
  // The quantiles of |a - 2 b + c| for unit normal scatter: sqrt(6) times those of |x|.
  constexpr double kLowerQuartile = 0.7805;
  constexpr double kMedian = 1.652;
  Look look{.record = record};
  std::vector<double> intervals_s;
  double resolution_V = 1e-3;
  for (std::size_t k = 1; k < record.size(); ++k) {
    intervals_s.push_back(look.dt_s(k));
    if (look.dv_V(k) != 0.0) resolution_V = std::min(resolution_V, std::abs(look.dv_V(k)));
  }
  look.longest_s = std::max(90.0, 20.0 * UpperMedian(std::move(intervals_s)));

  // The lower quartile is noise even where a drive cycle leaves few calm rows. A load may be noisy
  // where rests are not.
  const std::vector<double>& i_A = record.current_A;
  const auto of_range = BendQuantile(i_A, 0.25, [](std::size_t) { return 1.0; });
  const auto of_reading = BendQuantile(i_A, 0.25, [&](std::size_t k) {
    const double least_A = std::min({std::abs(i_A[k]), std::abs(i_A[k - 1]), std::abs(i_A[k - 2])});
    return least_A > kRestShare * largest_A ? least_A : 0.0;
  });
  look.largest_A = largest_A;
  look.noise_A = of_range.value_or(0.0) / kLowerQuartile;
  look.noise_share = of_reading.value_or(0.0) / kLowerQuartile;
  look.least_A = std::clamp(
      kBeyondNoise * look.noise_A, kRestShare * largest_A, kHiddenShare * largest_A);

  constexpr double kUnknown_V = 2e-3;
  const auto bend_V = BendQuantile(record.voltage_V, 0.5, [&](std::size_t k) {
    return look.Calm(k) && look.Calm(k - 1) ? 1.0 : 0.0;
  });
  look.noise_V = std::max(
      {bend_V ? *bend_V / kMedian : kUnknown_V, resolution_V / 2.0, 1e-7});
  for (const double v_V : record.voltage_V)
    look.mean_V += std::abs(v_V) / static_cast<double>(record.size());
  const Extent extent = FindExtent(i_A);
  look.one_sided = extent.least >= -look.least_A || extent.most <= look.least_A;
  return look;
}

struct Edge {
  std::size_t row = 0;
  double di_A = 0.0;
  double dv_V = 0.0;
  double scale_V = 0.0;
};

struct Edges {
  std::vector<Edge> all;
  double resistance_Ohm = 0.0;  // an amount
  double evidence = 0.0;

  // How much better a resistance (negative: discharge is negative) explains the edges than none.
  [[nodiscard]] double Gain(double resistance) const {
    double gain = 0.0;
    for (const Edge& edge : all) {
      gain += Odds(edge.dv_V / edge.scale_V) -
              Odds((edge.dv_V + resistance * edge.di_A) / edge.scale_V);
    }
    return gain;
  }
  // What one edge says for discharge being positive rather than negative.
  [[nodiscard]] double Of(const Edge& edge) const {
    const double drop_V = resistance_Ohm * edge.di_A;
    return Odds((edge.dv_V - drop_V) / edge.scale_V) - Odds((edge.dv_V + drop_V) / edge.scale_V);
  }
};

// The step of the voltage at an edge, as means of some rows before and after it between which the
// current keeps still, and how far it may be off.
Edge StepAt(const Look& look, std::size_t row, std::size_t rows) {
  constexpr double kNoise = 2.0;      // multiples of it that a step must have to say anything
  constexpr double kAftermath = 0.3;  // of an edge, in the row after it
  const Record& record = look.record;
  std::size_t first = row - 1;
  std::size_t last = row;
  while (first > 0 && row - first < rows && look.Calm(first)) --first;
  while (last + 1 < record.size() && last + 1 - row < rows && look.Calm(last + 1)) ++last;
  const auto mean = [](const std::vector<double>& column, std::size_t from, std::size_t to) {
    double sum = 0.0;
    for (std::size_t k = from; k <= to; ++k) sum += column[k];
    return sum / static_cast<double>(to - from + 1);
  };
  const auto before = static_cast<double>(row - first);
  const auto after = static_cast<double>(last - row + 1);
  // What the voltage was doing anyway.
  double anyway_V = 0.0;
  if (row - first > 1) {
    const double moved_V = std::abs(record.voltage_V[row - 1] - record.voltage_V[first]);
    anyway_V = std::max(0.0, moved_V - kNoise * std::sqrt(2.0) * look.noise_V) *
               (mean(record.time_s, row, last) - mean(record.time_s, first, row - 1)) /
               (record.time_s[row - 1] - record.time_s[first]);
  } else if (row > 1) {
    anyway_V = std::abs(look.dv_V(row - 1)) *
               (look.Calm(row - 1) ? look.dt_s(row) / look.dt_s(row - 1) : kAftermath);
  }
  const double noise_V = look.noise_V * std::sqrt(1.0 / before + 1.0 / after);
  return {row,
          look.di_A(row),
          mean(record.voltage_V, row, last) - mean(record.voltage_V, first, row - 1),
          std::hypot(kNoise * noise_V, anyway_V)};
}

Edges LookAtEdges(const Look& look) {
  // A short look is sharp, a long one averages noise: whichever shows more.
  constexpr std::size_t kLongLook = 8;
  Edges edges;
  std::vector<double> seen_Ohm;
  double squares = 0.0;
  double products = 0.0;
  for (std::size_t k = 1; k < look.record.size(); ++k) {
    if (!look.Changes(k) || look.dt_s(k) > look.longest_s) continue;
    Edge edge = StepAt(look, k, 1);
    const Edge slower = StepAt(look, k, kLongLook);
    if (std::abs(slower.dv_V) * edge.scale_V > std::abs(edge.dv_V) * slower.scale_V) edge = slower;
    const double weight = 1.0 / (edge.scale_V * edge.scale_V);
    squares += weight * edge.di_A * edge.di_A;
    products += weight * edge.di_A * edge.dv_V;
    if (std::abs(edge.dv_V) > edge.scale_V) seen_Ohm.push_back(std::abs(edge.dv_V / edge.di_A));
    edges.all.push_back(edge);
  }
  if (edges.all.empty()) return edges;
  const double mean_Ohm = std::abs(products / squares);
  edges.resistance_Ohm = seen_Ohm.empty() ? mean_Ohm : UpperMedian(std::move(seen_Ohm));
  const auto gain = [&](double side) {
    return std::max(
        {0.0, edges.Gain(side * edges.resistance_Ohm), edges.Gain(side * mean_Ohm)});
  };
  edges.evidence = gain(1.0) - gain(-1.0);
  return edges;
}

struct Flow {
  double evidence = 0.0;
  // The largest move against the evidence, from one row to another.
  double rise_V = 0.0;
  std::size_t rise_from = 0;
  std::size_t rise_to = 0;
};

// The charge that each row stands for, as a share of all that moved; none at rest. Empty where no
// charge moved.
std::vector<double> SharesOfCharge(const Look& look) {
  const Record& record = look.record;
  std::vector<double> shares(record.size(), 0.0);
  double sum = 0.0;
  for (std::size_t k = 1; k < record.size(); ++k) {
    const double half_s = 0.5 * std::min(look.dt_s(k), look.longest_s);
    for (const std::size_t end : {k - 1, k}) {
      if (look.Loaded(end)) shares[end] += half_s * std::abs(record.current_A[end]);
    }
  }
  for (const double share : shares) sum += share;
  if (!(sum > 0.0)) return {};
  for (double& share : shares) share /= sum;
  return shares;
}

// Covariances of current, charge and -voltage, weighted by charge.
using Covariance = std::array<std::array<double, 3>, 3>;

Covariance Covary(const Look& look, const std::vector<double>& shares) {
  const Record& record = look.record;
  std::array<double, 3> mean{};
  Covariance covariance{};
  // The first pass finds the means.
  for (const bool second : {false, true}) {
    double charge_C = 0.0;
    for (std::size_t k = 0; k < record.size(); ++k) {
      if (k > 0) {
        charge_C += 0.5 * (record.current_A[k] + record.current_A[k - 1]) *
                    std::min(look.dt_s(k), look.longest_s);
      }
      const std::array<double, 3> row{record.current_A[k], charge_C, -record.voltage_V[k]};
      for (std::size_t a = 0; a < 3; ++a) {
        if (!second) mean[a] += shares[k] * row[a];
        for (std::size_t b = 0; second && b < 3; ++b)
          covariance[a][b] += shares[k] * (row[a] - mean[a]) * (row[b] - mean[b]);
      }
    }
  }
  return covariance;
}

// The most of the voltage's variance that -v = R i + g q explains, where neither R nor g is against
// a side.
struct Explained {
  double resistance_Ohm = 0.0;
  double variance_V2 = 0.0;
};

Explained Explain(const Covariance& c, double largest_A, double side) {
  constexpr double kChanges = 0.01;  // share of the largest current that shows a resistance
  constexpr double kApart = 1e-6;    // of 1 - correlation^2
  const bool changes = c[0][0] > std::pow(kChanges * largest_A, 2);
  const double determinant = c[0][0] * c[1][1] - c[0][1] * c[0][1];
  if (changes && determinant > kApart * c[0][0] * c[1][1]) {
    const double resistance_Ohm = (c[0][2] * c[1][1] - c[1][2] * c[0][1]) / determinant;
    const double slope = (c[1][2] * c[0][0] - c[0][2] * c[0][1]) / determinant;
    if (side * resistance_Ohm >= 0.0 && side * slope >= 0.0)
      return {resistance_Ohm, resistance_Ohm * c[0][2] + slope * c[1][2]};
  }
  Explained best;
  if (c[1][1] > 0.0 && side * c[1][2] > 0.0) best.variance_V2 = c[1][2] * c[1][2] / c[1][1];
  if (changes && side * c[0][2] > 0.0 && c[0][2] * c[0][2] / c[0][0] > best.variance_V2)
    best = {c[0][2] / c[0][0], c[0][2] * c[0][2] / c[0][0]};
  return best;
}

Flow LookAtFlow(const Look& look) {
  const Record& record = look.record;
  const std::vector<double> shares = SharesOfCharge(look);
  if (shares.empty()) return {};
  const Covariance covariance = Covary(look, shares);
  const Explained plus = Explain(covariance, look.largest_A, 1.0);
  const Explained minus = Explain(covariance, look.largest_A, -1.0);
  const double side = plus.variance_V2 >= minus.variance_V2 ? 1.0 : -1.0;
  const Explained& better = side > 0.0 ? plus : minus;

  // Means of the voltage over equal parts of the charge, without the ohmic part, so that they fall
  // as time goes on.
  constexpr std::size_t kParts = 16;
  std::array<double, kParts> part_V{};
  std::array<double, kParts> part_share{};
  std::array<std::size_t, kParts> first{};
  double before = 0.0;
  double net = 0.0;
  double loaded_rows = 0.0;
  for (std::size_t k = 0; k < record.size(); ++k) {
    if (shares[k] == 0.0) continue;
    const auto part = std::min(
        kParts - 1, static_cast<std::size_t>((before + 0.5 * shares[k]) * double{kParts}));
    if (part_share[part] == 0.0) first[part] = k;
    part_share[part] += shares[k];
    part_V[part] +=
        shares[k] * (record.voltage_V[k] + better.resistance_Ohm * record.current_A[k]);
    before += shares[k];
    net += record.current_A[k] > 0.0 ? shares[k] : -shares[k];
    loaded_rows += 1.0;
  }
  for (std::size_t part = 0; part < kParts; ++part) {
    if (part_share[part] > 0.0) {
      part_V[part] *= (net >= 0.0 ? side : -side) / part_share[part];
    } else if (part > 0) {  // a row may be more than a part
      part_V[part] = part_V[part - 1];
      first[part] = first[part - 1];
    }
  }

  Flow flow;
  std::size_t lowest = 0;
  for (std::size_t part = 1; part < kParts; ++part) {
    if (part_V[part] < part_V[lowest]) lowest = part;
    if (part_V[part] - part_V[lowest] <= flow.rise_V) continue;
    flow = {0.0,
            part_V[part] - part_V[lowest],
            lowest + 1 < kParts ? first[lowest + 1] : first[lowest],
            part + 1 < kParts ? first[part + 1] : record.size()};
  }
  constexpr double kKeepsUp = 0.8;
  constexpr double kEnoughRows = 12.0;
  const auto mean_of_four = [&](std::size_t from) {
    return 0.25 * (part_V[from] + part_V[from + 1] + part_V[from + 2] + part_V[from + 3]);
  };
  const double early_V = mean_of_four(0) - mean_of_four(6);
  const double late_V = mean_of_four(6) - mean_of_four(12);
  const bool steady =
      loaded_rows >= kEnoughRows && early_V > 0.0 && late_V >= kKeepsUp * early_V;
  constexpr double kParameters = 3.0;
  const double freedom = loaded_rows > kParameters ? 1.0 - kParameters / loaded_rows : 1.0;
  const double missed_V2 =
      std::max(0.0, covariance[2][2] - better.variance_V2) / freedom;
  const double drift_V = look.drift_V(steady ? kSteadyDrift : kDrift);
  flow.evidence =
      6.0 * (plus.variance_V2 - minus.variance_V2) / (drift_V * drift_V + missed_V2);
  return flow;
}

// Rows of current of one sign, between rests.
struct Stretch {
  std::size_t first = 0;
  std::size_t last = 0;
};

std::vector<Stretch> FindStretches(const Look& look) {
  std::vector<Stretch> stretches;
  const std::vector<double>& i_A = look.record.current_A;
  for (std::size_t k = 0; k < i_A.size(); ++k) {
    if (!look.Loaded(k)) continue;
    const bool goes_on = k > 0 && look.Loaded(k - 1) && (i_A[k] > 0.0) == (i_A[k - 1] > 0.0);
    if (!goes_on) stretches.push_back({k, k});
    stretches.back().last = k;
  }
  return stretches;
}

// How far the voltage falls along the stretches, with the sign of their current.
double FallAlong(const Record& record, const std::vector<Stretch>& stretches) {
  double fall_V = 0.0;
  for (const auto& [first, last] : stretches) {
    const double drop_V = record.voltage_V[first] - record.voltage_V[last];
    fall_V += record.current_A[first] > 0.0 ? drop_V : -drop_V;
  }
  return fall_V;
}

// A voltage that is held while the current changes: the end of a charge, high up, or of a
// discharge, low down. It shows no direction of its own; where a side is given, only a hold that
// does not go with it counts.
bool HoldsVoltage(const Look& look,
                  const std::vector<Stretch>& stretches,
                  double resistance_Ohm,
                  std::optional<double> side) {
  const Record& record = look.record;
  constexpr double kShareOfCharge = 0.02;
  constexpr double kHeld = 0.3;   // of the ohmic part
  constexpr double kSeen = 10.0;  // multiples of the noise
  const std::vector<double> shares = SharesOfCharge(look);
  if (shares.empty()) return false;
  for (const auto& [first, last] : stretches) {
    double share = 0.0;
    double mean_V = 0.0;
    for (std::size_t k = first; k <= last; ++k) {
      share += shares[k];
      mean_V += record.voltage_V[k] / static_cast<double>(last - first + 1);
    }
    const auto extent = [&](const std::vector<double>& column) {
      return FindExtent({column.data() + first, last - first + 1});
    };
    const Extent v_V = extent(record.voltage_V);
    const Extent i_A = extent(record.current_A);
    constexpr double kNoiseRange = 8.0;  // from the least to the most of many rows
    const double noise_A =
        std::max(look.noise_A, look.noise_share * std::max(-i_A.least, i_A.most));
    const double ohmic_V =
        resistance_Ohm * std::max(0.0, i_A.most - i_A.least - kNoiseRange * noise_A);
    const bool held = ohmic_V > kSeen * look.noise_V && v_V.most - v_V.least < kHeld * ohmic_V;
    const bool high = mean_V > look.mean_V;
    const bool discharges = side && (*side > 0.0) == (record.current_A[first] > 0.0);
    if (share > kShareOfCharge && held && (!side || high == discharges)) return true;
  }
  return false;
}

std::string_view RisesOrFalls(bool falls) { return falls ? "falls" : "rises"; }

}  // namespace

SignFinding FindSignFromPhysics(const Record& whole) {
  const Record record = Thinned(whole);
  const double largest_A = LargestMagnitude(record.current_A);
  if (largest_A == 0.0) return {CurrentSign::kUnclear, "no current flows"};
  const Look look = LookAt(record, largest_A);
  const Edges edges = LookAtEdges(look);
  const Flow flow = LookAtFlow(look);
  const auto stretches = FindStretches(look);

  const double sum = edges.evidence + flow.evidence;
  if (!(std::abs(sum) >= kDecisive)) {  // NaN too, of numbers that overflow
    // Of a log that is all hold the resistance is not seen: the least that would show.
    const double least_Ohm = kSteadyDrift * look.mean_V / look.largest_A;
    const bool holds = look.one_sided && HoldsVoltage(look,
                                                      stretches,
                                                      std::max(edges.resistance_Ohm, least_Ohm),
                                                      std::nullopt);
    return {CurrentSign::kUnclear, "the voltage hardly moves with the current", holds};
  }
  const double side = sum > 0.0 ? 1.0 : -1.0;
  const double in_favour =
      std::max(0.0, side * edges.evidence) + std::max(0.0, side * flow.evidence);
  double against = std::max(0.0, -side * flow.evidence);
  if (look.one_sided) {
    double edges_in_rise = 0.0;
    for (const Edge& edge : edges.all) {
      const double says = side * edges.Of(edge);
      against += std::max(0.0, -says);
      if (edge.row >= flow.rise_from && edge.row < flow.rise_to) edges_in_rise += says;
    }
    // A rise during which the edges still say the same is a recovery under a lighter load.
    against += std::max(0.0,
                        0.5 * std::pow(flow.rise_V / look.drift_V(kDrift), 2) -
                            std::max(0.0, edges_in_rise));
  } else {
    against += std::max(0.0, -side * edges.evidence);
  }
  if (against > kAgainst + (look.one_sided ? kAgainstShareOfAmount : kAgainstShare) * in_favour) {
    return {CurrentSign::kUnclear,
            "the voltage falls with the current in some places and rises in others, as if the "
            "current had no sign",
            true};
  }
  if (look.one_sided && HoldsVoltage(look, stretches, edges.resistance_Ohm, side)) {
    return {CurrentSign::kUnclear,
            "the current has one sign and in places the voltage is held while it changes, as at "
            "the end of a charge",
            true};
  }

  const bool falls = side > 0.0;
  const double fall_V = FallAlong(record, stretches);
  std::string reason = "the voltage ";
  const bool has_edges = side * edges.evidence > 0.0;
  if (has_edges) {
    reason += fmt::format("{} where the current rises ({} edges, {:.3g} Ohm)",
                          RisesOrFalls(falls),
                          edges.all.size(),
                          edges.resistance_Ohm);
  }
  if (side * fall_V > 0.0) {
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
                          total(neither)),
              true};
    }
    return {CurrentSign::kUnsigned, reason};
  }
  return {CurrentSign::kUnclear,
          "the state column and the sign of the current contradict each other",
          true};
}

}  // namespace lipoid
