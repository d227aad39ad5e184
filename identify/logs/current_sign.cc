#include "identify/logs/current_sign.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "identify/logs/columns.h"
#include "model/core/counted.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// A cell whose discharge is positive has a voltage that falls as R i + g q, with R and g above 0
// and the charge q that has left; where its discharge is negative, both are below 0. How much
// better one side explains the voltage than the other is a log-likelihood ratio in nats, above 0
// for "discharge is positive". It is taken twice, and the two add up:
//
//   edges   from row to row, where the current changes and only R counts:
//           sum of ln(1 + ((dv - R di)/s)^2) - ln(1 + ((dv + R di)/s)^2). The tails are heavy
//           because one edge may be turned by a recovery or by a row that was written late. s is
//           the noise of the voltage and what the voltage was doing anyway.
//   flow    over the whole log: 6 (E_+ - E_-) / d^2, where E_+ and E_- are the variances of the
//           voltage, weighted by charge, that the two sides explain. An even fall by F volts has the
//           variance F^2 / 12 and so gives F^2 / (2 d^2). d is what a voltage moves by for other
//           reasons: a recovery from an earlier load, warming, and what such a simple cell misses.
//
// A sign is found where the sum is decisive and little stands against it.
constexpr double kDecisive = 6.0;  // odds of 400 to 1
// What may stand against a sign: this, and a share of what speaks for it.
constexpr double kAgainst = 2.0;
constexpr double kAgainstShare = 0.25;
// A current that never changes sign may be an amount, of charging as well as of discharging: then
// a few places that say the opposite are enough.
constexpr double kAgainstShareOfAmount = 0.02;

// Shares of the largest current: below the first a row is at rest, and no noise hides a change
// above the second.
constexpr double kLeastShareOfLoad = 0.02;
constexpr double kHiddenShare = 0.3;
// Multiples of its noise by which a current must change: of 10,000 rows of noise none does.
constexpr double kBeyondNoise = 7.0;

// What a voltage moves by on its own, as shares of it: 50 mV and 15 mV of 3.8 V. A move that slows
// down may be a recovery from an earlier load; one that keeps up is hardly that.
constexpr double kDrift = 0.013;
constexpr double kSteadyDrift = 0.004;

double Odds(double multiple_of_scale) { return std::log1p(multiple_of_scale * multiple_of_scale); }

// The columns, and what can be said of them without a sign. A load is a share of the largest
// current, with the sign of the file; a drop is the voltage that the resistance takes at a load of
// 1.
struct Look {
  std::vector<double> time_s;
  std::vector<double> load;
  std::vector<double> voltage_V;
  double noise = 0.0;          // of the load of one row
  double noise_of_load = 0.0;  // the same as a share of that load
  double noise_V = 0.0;        // of one row
  double longest_s = 0.0;      // across longer intervals the voltage moves for other reasons
  double mean_V = 0.0;
  bool one_sided = false;  // the current never changes sign

  [[nodiscard]] std::size_t size() const { return time_s.size(); }
  [[nodiscard]] double dt_s(std::size_t k) const { return time_s[k] - time_s[k - 1]; }
  [[nodiscard]] double di(std::size_t k) const { return load[k] - load[k - 1]; }
  [[nodiscard]] double dv_V(std::size_t k) const { return voltage_V[k] - voltage_V[k - 1]; }
  // A change of the load, at such loads, that is more than noise; at none: a load.
  [[nodiscard]] double Least(double at_load) const {
    return std::clamp(
        kBeyondNoise * std::max(noise, noise_of_load * at_load), kLeastShareOfLoad, kHiddenShare);
  }
  [[nodiscard]] bool Changes(std::size_t k) const {
    return std::abs(di(k)) >= Least(std::max(std::abs(load[k]), std::abs(load[k - 1])));
  }
  [[nodiscard]] bool Calm(std::size_t k) const { return !Changes(k) && dt_s(k) <= longest_s; }
  [[nodiscard]] bool Loaded(std::size_t k) const { return std::abs(load[k]) > Least(0.0); }
  // Whether a load goes on from the row before.
  [[nodiscard]] bool GoesOn(std::size_t k) const {
    return k > 0 && Loaded(k) && Loaded(k - 1) && (load[k] > 0.0) == (load[k - 1] > 0.0);
  }
  [[nodiscard]] double drift_V(double share) const {
    return std::hypot(share * mean_V, 2.0 * noise_V);
  }
};

// The noise of one row, from a quantile of |a - 2 b + c| over `unit(k)`, which is 0 for rows that
// do not count; for unit normal scatter that quantile is `expected`. Slow moves hardly show in it.
// None where there are so few rows that the shape of the curve might be all there is.
template <class Unit>
std::optional<double> NoiseOf(const std::vector<double>& column,
                              double quantile,
                              double expected,
                              const Unit& unit) {
  std::vector<double> bends;
  for (std::size_t k = 2; k < column.size(); ++k) {
    const double one = unit(k);
    if (one > 0.0) bends.push_back(std::abs(column[k] - 2.0 * column[k - 1] + column[k - 2]) / one);
  }
  constexpr std::size_t kEnough = 5;
  if (bends.size() < kEnough) return std::nullopt;
  const auto place = static_cast<std::size_t>(quantile * static_cast<double>(bends.size()));
  return ValueAtPlace(bends, place) / expected;
}

Look LookAt(const Record& record, double largest_A) {
  Look look;
  // Of a long log every n-th row: what a slower logger would have written says as much.
  constexpr std::size_t kEnoughRows = std::size_t{1} << 17;
  const std::size_t stride = record.size() / kEnoughRows + 1;
  for (std::size_t k = 0; k < record.size(); k += stride) {
    look.time_s.push_back(record.time_s[k]);
    look.load.push_back(record.current_A[k] / largest_A);
    look.voltage_V.push_back(record.voltage_V[k]);
    look.mean_V += std::abs(record.voltage_V[k]);
  }
  look.mean_V /= static_cast<double>(look.size());
  std::vector<double> intervals_s;
  double resolution_V = 1e-3;
  for (std::size_t k = 1; k < look.size(); ++k) {
    intervals_s.push_back(look.dt_s(k));
    if (look.dv_V(k) != 0.0) resolution_V = std::min(resolution_V, std::abs(look.dv_V(k)));
  }
  look.longest_s = std::max(90.0, 20.0 * UpperMedian(std::move(intervals_s)));

  // sqrt(6) times the quartile and the median of |x| for unit normal scatter. The quartile is noise
  // even where a drive cycle leaves few calm rows. A load may be noisy where rests are not.
  constexpr double kQuartile = 0.7805;
  constexpr double kMedian = 1.652;
  const std::vector<double>& load = look.load;
  look.noise = NoiseOf(load, 0.25, kQuartile, [](std::size_t) { return 1.0; }).value_or(0.0);
  look.noise_of_load = NoiseOf(load, 0.25, kQuartile, [&](std::size_t k) {
                         const double least = std::min(
                             {std::abs(load[k]), std::abs(load[k - 1]), std::abs(load[k - 2])});
                         return least > kLeastShareOfLoad ? least : 0.0;
                       }).value_or(0.0);
  constexpr double kUnknown_V = 2e-3;
  const double bend_V = NoiseOf(look.voltage_V, 0.5, kMedian, [&](std::size_t k) {
                          return look.Calm(k) && look.Calm(k - 1) ? 1.0 : 0.0;
                        }).value_or(kUnknown_V);
  look.noise_V = std::max({bend_V, resolution_V / 2.0, 1e-7});
  const Extent extent = FindExtent(load);
  look.one_sided = extent.least >= -look.Least(0.0) || extent.most <= look.Least(0.0);
  return look;
}

struct Edge {
  std::size_t row = 0;
  double di = 0.0;
  double dv_V = 0.0;
  double scale_V = 0.0;

  // How much better this drop explains the edge than the opposite one.
  [[nodiscard]] double Of(double drop_V) const {
    return Odds((dv_V - drop_V * di) / scale_V) - Odds((dv_V + drop_V * di) / scale_V);
  }
};

struct Edges {
  std::vector<Edge> all;
  double drop_V = 0.0;  // an amount
  double evidence = 0.0;
};

// The step of the voltage at an edge, as means of some rows before and after it between which the
// current keeps still, and how far it may be off.
Edge StepAt(const Look& look, std::size_t row, std::size_t rows) {
  constexpr double kNoise = 2.0;      // multiples of it that a step must have to say anything
  constexpr double kAftermath = 0.3;  // of an edge, in the row after it
  std::size_t first = row - 1;
  std::size_t last = row;
  while (first > 0 && row - first < rows && look.Calm(first)) --first;
  while (last + 1 < look.size() && last + 1 - row < rows && look.Calm(last + 1)) ++last;
  const auto before = static_cast<double>(row - first);
  const auto after = static_cast<double>(last - row + 1);
  const auto step = [&](const std::vector<double>& column) {
    double sum_before = 0.0;
    double sum_after = 0.0;
    for (std::size_t k = first; k < row; ++k) sum_before += column[k];
    for (std::size_t k = row; k <= last; ++k) sum_after += column[k];
    return sum_after / after - sum_before / before;
  };
  // What the voltage was doing anyway.
  double anyway_V = 0.0;
  if (row - first > 1) {
    const double moved_V = std::abs(look.voltage_V[row - 1] - look.voltage_V[first]);
    anyway_V = std::max(0.0, moved_V - kNoise * std::sqrt(2.0) * look.noise_V) * step(look.time_s) /
               (look.time_s[row - 1] - look.time_s[first]);
  } else if (row > 1) {
    anyway_V = std::abs(look.dv_V(row - 1)) *
               (look.Calm(row - 1) ? look.dt_s(row) / look.dt_s(row - 1) : kAftermath);
  }
  const double noise_V = look.noise_V * std::sqrt(1.0 / before + 1.0 / after);
  return {row, look.di(row), step(look.voltage_V), std::hypot(kNoise * noise_V, anyway_V)};
}

Edges LookAtEdges(const Look& look) {
  // A short look is sharp, a long one averages noise: whichever shows more.
  constexpr std::size_t kLongLook = 8;
  Edges edges;
  std::vector<double> seen_V;
  std::vector<double> all_V;
  for (std::size_t k = 1; k < look.size(); ++k) {
    if (!look.Changes(k) || look.dt_s(k) > look.longest_s) continue;
    Edge edge = StepAt(look, k, 1);
    const Edge slower = StepAt(look, k, kLongLook);
    if (std::abs(slower.dv_V) * edge.scale_V > std::abs(edge.dv_V) * slower.scale_V) edge = slower;
    all_V.push_back(std::abs(edge.dv_V / edge.di));
    if (std::abs(edge.dv_V) > edge.scale_V) seen_V.push_back(all_V.back());
    edges.all.push_back(edge);
  }
  if (edges.all.empty()) return edges;
  edges.drop_V = UpperMedian(seen_V.empty() ? std::move(all_V) : std::move(seen_V));
  const auto gain = [&](double drop_V) {
    double sum = 0.0;
    for (const Edge& edge : edges.all)
      sum += Odds(edge.dv_V / edge.scale_V) - Odds((edge.dv_V + drop_V * edge.di) / edge.scale_V);
    return std::max(0.0, sum);
  };
  edges.evidence = gain(edges.drop_V) - gain(-edges.drop_V);
  return edges;
}

// What the noise makes of a load that is steady on the whole, where it is more than any change that is looked for:
// such edges say nothing. 0 where the load changes by more than its noise.
double EdgesOfNoise(const Look& look) {
  constexpr double kSteady = 0.25;  // of the mean load
  constexpr double kOfNoise = 1.3;  // that from row to row
  constexpr double kOfLoad = 0.7;   // what is more switches it on or off
  double count = 0.0;
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t k = 1; k < look.size(); ++k) {
    if (!look.GoesOn(k)) continue;
    count += 1.0;
    sum += std::abs(look.load[k]);
    squares += look.load[k] * look.load[k];
  }
  const double mean = sum / std::max(count, 1.0);
  const double scatter = std::sqrt(std::max(0.0, squares / std::max(count, 1.0) - mean * mean));
  const double noise = std::max(look.noise, look.noise_of_load * mean);
  const bool steady = scatter < kSteady * mean && scatter < kOfNoise * noise;
  return steady ? std::min(kBeyondNoise * noise, kOfLoad * mean) : 0.0;
}

// The charge that each row stands for, as a share of all that moved; none at rest. Empty where no
// charge moved.
std::vector<double> SharesOfCharge(const Look& look) {
  std::vector<double> shares(look.size(), 0.0);
  double sum = 0.0;
  for (std::size_t k = 1; k < look.size(); ++k) {
    const double half_s = 0.5 * std::min(look.dt_s(k), look.longest_s);
    for (const std::size_t end : {k - 1, k}) {
      if (!look.Loaded(end)) continue;
      shares[end] += half_s * std::abs(look.load[end]);
      sum += half_s * std::abs(look.load[end]);
    }
  }
  if (!(sum > 0.0)) return {};
  for (double& share : shares) share /= sum;
  return shares;
}

// Of the load, the charge and the fall of the voltage.
using Covariance = std::array<std::array<double, 3>, 3>;

Covariance Covary(const Look& look, const std::vector<double>& shares) {
  std::array<double, 3> mean{};
  Covariance covariance{};
  for (const bool second : {false, true}) {
    double charge = 0.0;
    for (std::size_t k = 0; k < look.size(); ++k) {
      if (k > 0) charge += 0.5 * look.dt_s(k) * (look.load[k - 1] + look.load[k]);
      if (shares[k] == 0.0) continue;
      const std::array<double, 3> row{look.load[k], charge, -look.voltage_V[k]};
      for (std::size_t a = 0; a < 3; ++a) {
        if (!second) mean[a] += shares[k] * row[a];
        for (std::size_t b = 0; second && b < 3; ++b)
          covariance[a][b] += shares[k] * (row[a] - mean[a]) * (row[b] - mean[b]);
      }
    }
  }
  return covariance;
}

// The most of the voltage's variance that -v = drop i + g q explains, where neither is against a
// side.
struct Explained {
  double drop_V = 0.0;
  double variance_V2 = 0.0;
};

Explained Explain(const Covariance& c, double side) {
  constexpr double kChanges = 0.01;  // of the load, that shows a resistance
  constexpr double kApart = 1e-6;    // of 1 - correlation^2
  const bool changes = c[0][0] > kChanges * kChanges;
  const double determinant = c[0][0] * c[1][1] - c[0][1] * c[0][1];
  if (changes && determinant > kApart * c[0][0] * c[1][1]) {
    const double drop_V = (c[0][2] * c[1][1] - c[1][2] * c[0][1]) / determinant;
    const double slope = (c[1][2] * c[0][0] - c[0][2] * c[0][1]) / determinant;
    if (side * drop_V >= 0.0 && side * slope >= 0.0)
      return {drop_V, drop_V * c[0][2] + slope * c[1][2]};
  }
  Explained best;
  if (c[1][1] > 0.0 && side * c[1][2] > 0.0) best.variance_V2 = c[1][2] * c[1][2] / c[1][1];
  if (changes && side * c[0][2] > 0.0 && c[0][2] * c[0][2] / c[0][0] > best.variance_V2)
    best = {c[0][2] / c[0][0], c[0][2] * c[0][2] / c[0][0]};
  return best;
}

struct Flow {
  double evidence = 0.0;
  // The largest move against the evidence, and the rows between which it happened.
  double rise_V = 0.0;
  std::size_t rise_from = 0;
  std::size_t rise_to = 0;
};

Flow LookAtFlow(const Look& look) {
  const std::vector<double> shares = SharesOfCharge(look);
  if (shares.empty()) return {};
  const Covariance covariance = Covary(look, shares);
  const Explained plus = Explain(covariance, 1.0);
  const Explained minus = Explain(covariance, -1.0);
  const double side = plus.variance_V2 >= minus.variance_V2 ? 1.0 : -1.0;
  const Explained& better = side > 0.0 ? plus : minus;

  // Means of the voltage over parts of about equal charge, without the ohmic part. A row may be
  // more than a part.
  constexpr std::size_t kParts = 16;
  struct Part {
    std::size_t number = 0;
    std::size_t first = 0;
    double share = 0.0;
    double sum_V = 0.0;
    [[nodiscard]] double mean_V() const { return sum_V / share; }
  };
  std::vector<Part> parts;
  double before = 0.0;
  double net = 0.0;
  for (std::size_t k = 0; k < look.size(); ++k) {
    if (shares[k] == 0.0) continue;
    const auto number =
        std::min(kParts - 1, static_cast<std::size_t>((before + 0.5 * shares[k]) * double{kParts}));
    if (parts.empty() || parts.back().number != number) parts.push_back({number, k});
    parts.back().share += shares[k];
    parts.back().sum_V += shares[k] * (look.voltage_V[k] + better.drop_V * look.load[k]);
    before += shares[k];
    net += look.load[k] > 0.0 ? shares[k] : -shares[k];
  }
  // With this sign they fall as time goes on.
  const double down = net >= 0.0 ? side : -side;

  Flow flow;
  std::size_t lowest = 0;
  for (std::size_t part = 1; part < parts.size(); ++part) {
    const double rise_V = down * (parts[part].mean_V() - parts[lowest].mean_V());
    if (rise_V < 0.0) lowest = part;
    if (rise_V <= flow.rise_V) continue;
    flow.rise_V = rise_V;
    flow.rise_from = parts[lowest + 1].first;
    flow.rise_to = part + 1 < parts.size() ? parts[part + 1].first : look.size();
  }
  constexpr double kKeepsUp = 0.8;
  const auto fall_V = [&](std::size_t from) {  // over 6 parts, between means of 4
    double sum_V = 0.0;
    for (std::size_t k = from; k < from + 4; ++k)
      sum_V += 0.25 * down * (parts[k].mean_V() - parts[k + 6].mean_V());
    return sum_V;
  };
  const bool steady =
      parts.size() == kParts && fall_V(0) > 0.0 && fall_V(6) >= kKeepsUp * fall_V(0);
  const double missed_V2 = std::max(0.0, covariance[2][2] - better.variance_V2);
  const double drift_V = look.drift_V(steady ? kSteadyDrift : kDrift);
  flow.evidence = 6.0 * (plus.variance_V2 - minus.variance_V2) / (drift_V * drift_V + missed_V2);
  return flow;
}

// Whether the rise of the flow happened under one load that an edge began which says `side`: a cell that warms in the
// cold recovers under its load. A current whose sign is lost in between would show twice its drop at once.
bool IsRecovery(const Look& look, const Edges& edges, const Flow& flow, double side) {
  constexpr double kAtOnce = 0.5;  // of the drop of the load
  std::size_t first = flow.rise_from;
  while (first > 0 && look.GoesOn(first) && !look.Changes(first)) --first;
  const auto began = std::find_if(
      edges.all.begin(), edges.all.end(), [&](const Edge& edge) { return edge.row == first; });
  if (began == edges.all.end() || look.Loaded(first - 1)) return false;
  if (began->Of(side * edges.drop_V) < kDecisive) return false;
  const double most_V = kAtOnce * edges.drop_V * std::abs(look.load[first]);
  for (std::size_t k = first + 1; k < flow.rise_to; ++k) {
    if (!look.GoesOn(k) || look.Changes(k)) return false;
    if (std::abs(look.dv_V(k)) > most_V) return false;
  }
  return true;
}

// A voltage that is held while the load changes ends a charge, high up, or a discharge, low down.
// Whether one is held where the side says that it should not be; of no side, whether any is.
bool HoldsVoltage(const Look& look, double drop_V, double side) {
  constexpr double kHeld = 0.3;        // of the ohmic part
  constexpr double kSeen = 10.0;       // multiples of the noise
  constexpr double kNoiseRange = 8.0;  // from the least to the most of many rows
  for (std::size_t first = 0, next = 1; first < look.size(); first = next++) {
    while (next < look.size() && look.GoesOn(next) && !look.Changes(next)) ++next;
    const Extent v_V = FindExtent({look.voltage_V.data() + first, next - first});
    const Extent load = FindExtent({look.load.data() + first, next - first});
    const double noise =
        std::max(look.noise, look.noise_of_load * std::max(-load.least, load.most));
    const double ohmic_V = drop_V * (load.most - load.least - kNoiseRange * noise);
    const bool held = ohmic_V > kSeen * look.noise_V && v_V.most - v_V.least < kHeld * ohmic_V;
    const bool high = v_V.least + v_V.most > 2.0 * look.mean_V;
    if (held && (side == 0.0 || high == (side * look.load[first] > 0.0))) return true;
  }
  return false;
}

std::string Describe(const Look& look, const Edges& edges, double side, double largest_A) {
  const std::string_view moves = side > 0.0 ? "falls" : "rises";
  double fall_V = 0.0;
  for (std::size_t k = 1; k < look.size(); ++k) {
    if (look.GoesOn(k)) fall_V -= look.load[k] > 0.0 ? look.dv_V(k) : -look.dv_V(k);
  }
  std::string text = "the voltage";
  const bool has_edges = side * edges.evidence > 0.0;
  if (has_edges) {
    text += fmt::format(" {} where the current rises ({}, {:.3g} Ohm)",
                        moves,
                        Counted(edges.all.size(), "edge"),
                        edges.drop_V / largest_A);
  }
  if (side * fall_V > 0.0 || !has_edges) {
    text += fmt::format("{} {} while positive current flows ({:.3g} V in all)",
                        has_edges ? " and" : "",
                        moves,
                        std::abs(fall_V));
  }
  return text;
}

// Of a current that never changes sign, the first steady load under which the voltage rises by much and the
// first under which it falls by as much; "" where it does not go both ways.
std::string WhereBothWays(const Record& record) {
  constexpr double kSteady = 0.1;  // of the load
  constexpr double kMuch = 0.2;    // of the highest voltage, which no recovery makes
  const Extent current = FindExtent(record.current_A);
  const double least_A = kLeastShareOfLoad * current.Magnitude();
  if (record.voltage_V.empty() || std::min(-current.least, current.most) > least_A) return "";
  const double much_V = kMuch * LargestMagnitude(record.voltage_V);
  std::string rises;
  std::string falls;
  for (std::size_t first = 0, next = 1; first < record.size(); first = next++) {
    const double load_A = std::abs(record.current_A[first]);
    if (load_A <= least_A) continue;
    while (next < record.size() &&
           std::abs(std::abs(record.current_A[next]) - load_A) <= kSteady * load_A)
      ++next;
    const double rise_V = record.voltage_V[next - 1] - record.voltage_V[first];
    std::string& which = rise_V > 0.0 ? rises : falls;
    if (std::abs(rise_V) < much_V || !which.empty()) continue;
    which =
        fmt::format("from {:.10g} s to {:.10g} s", record.time_s[first], record.time_s[next - 1]);
  }
  if (rises.empty() || falls.empty()) return "";
  return fmt::format("falls {} and rises {}", falls, rises);
}

}  // namespace

SignFinding FindSignFromPhysics(const Record& record) {
  constexpr std::size_t kFewRows = 5;
  const double largest_A = LargestMagnitude(record.current_A);
  if (largest_A == 0.0) return {CurrentSign::kUnclear, "no current flows"};
  const Look look = LookAt(record, largest_A);
  const Edges edges = LookAtEdges(look);
  const Flow flow = LookAtFlow(look);

  const double sum = edges.evidence + flow.evidence;
  const double rise = flow.rise_V / look.drift_V(kDrift);
  const double of_rise = 0.5 * rise * rise;
  const auto both_ways = [&]() -> SignFinding {
    const std::string where = WhereBothWays(record);
    return {
        CurrentSign::kUnclear,
        fmt::format(
            "the voltage {}, as if the current had no sign or another pack began in between",
            where.empty() ? "falls with the current in some places and rises in others" : where),
        true};
  };
  if (!(std::abs(sum) >= kDecisive)) {  // NaN too, of numbers that overflow
    if (look.one_sided && of_rise > kDecisive) return both_ways();
    // Of a log that is all hold the resistance is not seen: the least that would show.
    const double least_V = std::max(edges.drop_V, kSteadyDrift * look.mean_V);
    return {
        CurrentSign::kUnclear,
        record.size() < kFewRows
            ? fmt::format("a log of {} is too short to show how the voltage moves with the current",
                          Counted(record.size(), "row"))
            : "the voltage hardly moves with the current",
        look.one_sided && HoldsVoltage(look, least_V, 0.0)};
  }
  const double side = sum > 0.0 ? 1.0 : -1.0;
  const double in_favour =
      std::max(0.0, side * edges.evidence) + std::max(0.0, side * flow.evidence);
  double against = in_favour - side * sum;
  if (look.one_sided) {
    // Here even one edge counts, and a rise of the voltage, unless the edges during it still say
    // the same: then it is a recovery under a lighter load.
    against = std::max(0.0, -side * flow.evidence);
    double edges_in_rise = 0.0;
    const double of_noise = EdgesOfNoise(look);
    for (const Edge& edge : edges.all) {
      if (std::abs(edge.di) < of_noise) continue;
      const double says = edge.Of(side * edges.drop_V);
      against += std::max(0.0, -says);
      if (edge.row >= flow.rise_from && edge.row < flow.rise_to) edges_in_rise += says;
    }
    if (!IsRecovery(look, edges, flow, side))
      against += std::max(0.0, of_rise - std::max(0.0, edges_in_rise));
  }
  if (against > kAgainst + (look.one_sided ? kAgainstShareOfAmount : kAgainstShare) * in_favour)
    return both_ways();
  if (look.one_sided && HoldsVoltage(look, edges.drop_V, side)) {
    return {CurrentSign::kUnclear,
            "the current has one sign and in places the voltage is held while it changes, as at "
            "the end of a charge",
            true};
  }
  return {side > 0.0 ? CurrentSign::kDischargePositive : CurrentSign::kDischargeNegative,
          Describe(look, edges, side, largest_A)};
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
    if (std::abs(record.current_A[k]) < kLeastShareOfLoad * largest_A) continue;
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
    return fmt::format("{} where the current is {} ({})",
                       what,
                       count[0] >= count[1] ? "positive" : "negative",
                       Counted(std::max(count[0], count[1]), "row"));
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
              fmt::format("the current has no sign of its own, and in {} with current the "
                          "state column says neither charge nor discharge",
                          Counted(total(neither), "row")),
              true};
    }
    return {CurrentSign::kUnsigned, reason};
  }
  return {CurrentSign::kUnclear,
          "the state column and the sign of the current contradict each other",
          true};
}

bool HasNoSign(const Record& record) { return !WhereBothWays(record).empty(); }

}  // namespace lipoid
