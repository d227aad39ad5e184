#include "identify/health/followed_current.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "identify/logs/flight/updates.h"
#include "model/core/special_values.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Changes larger than this many standard deviations of the usual ones are jumps of the level.
constexpr double kJump = 6.0;

// Of differences of normal noise, whatever else some of them hold.
double UsualDeviation(std::vector<double> differences) {
  constexpr double kMedianOfNormal = 0.6745;
  for (double& d : differences) d = std::abs(d);
  return differences.empty() ? 0.0 : Median(std::move(differences)) / kMedianOfNormal;
}

// Whether the level jumps on the way to each row; at the first it does.
std::vector<bool> FindJumps(const std::vector<double>& current_A) {
  std::vector<double> steps;
  for (std::size_t k = 1; k < current_A.size(); ++k)
    steps.push_back(current_A[k] - current_A[k - 1]);
  const double largest_A = kJump * UsualDeviation(steps);
  std::vector<bool> jumps(current_A.size(), true);
  for (std::size_t k = 1; k < current_A.size(); ++k) jumps[k] = std::abs(steps[k - 1]) > largest_A;
  return jumps;
}

struct Level {
  std::vector<double> mean;
  double noise_variance = 0.0;
  double minus_log_likelihood = kInfinity;
};

// By the filter of Kalman and the smoother of Rauch, Tung and Striebel. The walk has `per_s` variances of the noise
// a second; nothing is known of the level after a jump.
Level Smooth(const std::vector<double>& time_s,
             const std::vector<double>& current_A,
             const std::vector<bool>& jumps,
             double per_s) {
  const std::size_t n = current_A.size();
  Level level;
  level.mean = current_A;
  std::vector<double> variance(n);   // of the filtered level, in units of that of the noise
  std::vector<double> predicted(n);  // before the row
  double squares = 0.0;
  double logarithms = 0.0;
  double told = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    if (jumps[k]) {
      variance[k] = 1.0;
      continue;
    }
    predicted[k] = variance[k - 1] + per_s * (time_s[k] - time_s[k - 1]);
    const double of_row = predicted[k] + 1.0;
    const double surprise = current_A[k] - level.mean[k - 1];
    level.mean[k] = level.mean[k - 1] + predicted[k] / of_row * surprise;
    variance[k] = predicted[k] / of_row;
    squares += surprise * surprise / of_row;
    logarithms += std::log(of_row);
    ++told;
  }
  level.noise_variance = squares / told;
  level.minus_log_likelihood = 0.5 * (told * std::log(level.noise_variance) + logarithms);
  for (std::size_t k = n - 1; k-- > 0;) {
    if (jumps[k + 1]) continue;
    level.mean[k] += variance[k] / predicted[k + 1] * (level.mean[k + 1] - level.mean[k]);
  }
  return level;
}

// How much of the noise the voltage follows at the lag at which it follows most, and the standard deviation of that.
struct Following {
  double resistance_Ohm = 0.0;
  double deviation_Ohm = 0.0;
  double current_A = 0.0;  // standard deviations of a row
  double voltage_V = 0.0;
};

// Second differences, which leave level and drift alone.
std::vector<double> Bends(const std::vector<double>& x) {
  std::vector<double> bends;
  for (std::size_t k = 1; k + 1 < x.size(); ++k) bends.push_back(x[k - 1] - 2.0 * x[k] + x[k + 1]);
  return bends;
}

Following FollowedBy(const FlightSamples& flight) {
  const Record& record = flight.record;
  std::vector<double> voltage_V;
  for (const std::size_t row : flight.fresh) voltage_V.push_back(record.voltage_V[row]);
  const std::vector<double> bends_V = Bends(voltage_V);
  const double step_s = std::max(MedianInterval(record.time_s), flight.current_update_s);
  const int reach = static_cast<int>(std::ceil(kLargestLag_s / step_s));
  Following most;
  for (int lag = -reach; lag <= reach; ++lag) {
    Follower follow(record.time_s);
    std::vector<double> current_A;
    for (const std::size_t fresh : flight.fresh) {
      const auto [row, share] = follow(record.time_s[fresh] - lag * step_s);
      current_A.push_back((1.0 - share) * record.current_A[row] +
                          share * record.current_A[row + 1]);
    }
    const std::vector<double> bends_A = Bends(current_A);
    const double farthest_A = kJump * UsualDeviation(bends_A);
    double rows = 0.0, ii = 0.0, vv = 0.0, vi = 0.0;
    for (std::size_t k = 0; k < bends_A.size(); ++k) {
      if (std::abs(bends_A[k]) > farthest_A) continue;
      ++rows;
      ii += bends_A[k] * bends_A[k];
      vv += bends_V[k] * bends_V[k];
      vi += bends_V[k] * bends_A[k];
    }
    constexpr double kFewest = 100.0;
    if (rows < kFewest || !(ii > 0.0)) return {};
    // Neighbours share rows: the squares of the correlations of the bends of white noise, 1, 4/6 and 1/6, summed.
    constexpr double kShared = 35.0 / 18.0;
    if (lag > -reach && -vi / ii < most.resistance_Ohm) continue;
    most.resistance_Ohm = -vi / ii;
    most.deviation_Ohm = std::sqrt(kShared * vv / ii / rows);
    most.current_A = std::sqrt(ii / (6.0 * rows));
    most.voltage_V = std::sqrt(vv / (6.0 * rows));
  }
  return most;
}

}  // namespace

std::optional<FollowedCurrent> TakeOutUnfollowed(const FlightSamples& flight) {
  constexpr double kMatters = 0.3;       // of the noise of the voltage
  constexpr double kLeastShare = 0.003;  // of the largest current: less moves nothing that is asked
  constexpr double kMostFollowed = 0.5;  // of the noise, by the voltage
  constexpr double kSurely = 5.0;        // standard deviations: the lag is the best of many
  const Record& record = flight.record;
  const double edge_Ohm = flight.edge_resistance_Ohm;  // by the largest changes
  if (!(edge_Ohm > 0.0)) return std::nullopt;
  const Following following = FollowedBy(flight);
  if (!(following.current_A > kLeastShare * flight.largest_A)) return std::nullopt;
  if (!(following.current_A * edge_Ohm > kMatters * following.voltage_V)) return std::nullopt;
  if (following.resistance_Ohm + kSurely * following.deviation_Ohm > kMostFollowed * edge_Ohm)
    return std::nullopt;
  const auto fresh = FreshRows(record.time_s, record.current_A, flight.current_update_s);
  std::vector<double> time_s, current_A;
  for (const std::size_t row : fresh) {
    time_s.push_back(record.time_s[row]);
    current_A.push_back(record.current_A[row]);
  }
  const std::vector<bool> jumps = FindJumps(current_A);
  // From a level that holds for a flight of days to one that is free at each row.
  Level best;
  for (double per_s = 1e-6; per_s < 1e4; per_s *= 2.0) {
    Level level = Smooth(time_s, current_A, jumps, per_s);
    if (level.minus_log_likelihood < best.minus_log_likelihood) best = std::move(level);
  }
  if (best.mean.empty()) return std::nullopt;
  FollowedCurrent found{Column(record.size()), std::sqrt(best.noise_variance)};
  for (std::size_t f = 0; f < fresh.size(); ++f) {
    const std::size_t end = f + 1 < fresh.size() ? fresh[f + 1] : record.size();
    for (std::size_t k = fresh[f]; k < end; ++k) found.current_A[k] = best.mean[f];
  }
  return found;
}

}  // namespace lipoid
