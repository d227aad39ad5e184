#include "identify/joint/leave_out.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <span>

#include "model/core/parallel.h"
#include "model/statistics/quantiles.h"

namespace lipoid {

namespace {

constexpr double kFitted = 0.368;  // e^-1: the share of rows that a bootstrap leaves out

// The unknowns at these rates for every smoothness: of all rows, and without each group.
struct Held {
  std::vector<Eigen::VectorXd> whole;
  std::vector<std::vector<Eigen::VectorXd>> without;  // [group][smoothness]
  double weight = 0.0;                                // of what is in a group
};

Held SolveWithoutEach(const JointFit& fit,
                      const AtRates& sweep,
                      const Grouping& by,
                      const std::vector<double>& ladder) {
  const auto sums = SumGroups(sweep, by);
  const JointStructure& structure = sweep.structure;
  const JointRates& rates = sweep.rates;
  Held held;
  NormalEquations total = sums.back();
  for (int g = 0; g < by.groups; ++g) {
    total.Add(sums[g]);
    held.weight += sums[g].weight;
  }
  std::vector<std::vector<char>> guess;  // what holds with all rows mostly holds without some
  for (const double smoothness : ladder) {
    JointSolution solution = fit.SolveSums(
        structure, rates, smoothness, total, guess.empty() ? std::vector<char>{} : guess.back());
    held.whole.push_back(std::move(solution.x));
    guess.push_back(std::move(solution.active));
  }
  held.without.resize(static_cast<std::size_t>(by.groups));
  ParallelFor(held.without.size(), [&](std::size_t g) {
    NormalEquations rest = total;
    rest.Add(sums[g], -1.0);
    for (std::size_t s = 0; s < ladder.size(); ++s)
      held.without[g].push_back(fit.SolveSums(structure, rates, ladder[s], rest, guess[s]).x);
  });
  return held;
}

}  // namespace

LeftOutErrors LeaveOut(const JointFit& fit,
                       const JointLogs& logs,
                       const JointStructure& structure,
                       const JointRates& rates,
                       const std::vector<double>& ladder) {
  LeftOutErrors best;
  if (!ladder.empty()) best.smoothness = ladder[ladder.size() / 2];
  if (logs.groups < 2) return best;
  const JointSetup& setup = fit.seen().setup();
  const SocTrace soc = TraceSoc(logs, setup, rates);
  const AtRates sweep{logs, setup, structure, soc, rates};
  const Held held = SolveWithoutEach(fit, sweep, logs.Pieces(), ladder);
  const double weight = held.weight;
  const auto total_of = [&](const std::vector<double>& units) {
    return std::accumulate(units.begin(), units.end(), 0.0) / weight;
  };
  // One sweep for both: of what is left out, then of all rows.
  std::vector<std::vector<Eigen::VectorXd>> unknowns = held.without;
  for (auto& group : unknowns) group.insert(group.end(), held.whole.begin(), held.whole.end());
  const auto errors = SumErrors(sweep, logs.Pieces(), unknowns);
  const auto fitted = std::span(errors).subspan(ladder.size());
  const auto errors_of =
      [&](std::size_t s, const std::vector<double>& with, const std::vector<double>& without) {
        LeftOutErrors one{
            .smoothness = ladder[s], .fitted_V = total_of(with), .left_out_V = total_of(without)};
        one.expected_V = kFitted * one.fitted_V + (1.0 - kFitted) * one.left_out_V;
        for (std::size_t u = 0; u < with.size(); ++u)
          one.unit_V.push_back(kFitted * with[u] + (1.0 - kFitted) * without[u]);
        return one;
      };
  std::vector<LeftOutErrors> all;
  for (std::size_t s = 0; s < ladder.size(); ++s) all.push_back(errors_of(s, fitted[s], errors[s]));
  double least_V = std::numeric_limits<double>::infinity();
  for (const LeftOutErrors& one : all) least_V = std::min(least_V, one.expected_V);
  std::size_t taken = 0;
  while (taken + 1 < all.size() && !(all[taken].expected_V <= (1.0 + kSmoothnessLoss) * least_V))
    ++taken;
  if (!logs.stretched) return all[taken];
  const Held apart = SolveWithoutEach(fit, sweep, logs.Stretches(), {ladder[taken]});
  const auto far = SumErrors(sweep, logs.Stretches(), apart.without);
  return errors_of(taken, fitted[taken], far[0]);
}

ExpectedError ExpectError(const JointFit& fit,
                          const JointLogs& logs,
                          const JointSolution& solution,
                          const TrustReport& trust) {
  Require(trust.new_over_fitted.size() == logs.logs.size(), "the trust in a fit of these logs");
  ExpectedError expected;
  if (logs.groups < 2 || solution.x.size() == 0) return expected;
  const JointSetup& setup = fit.seen().setup();
  const SocTrace soc = TraceSoc(logs, setup, solution.rates);
  const AtRates sweep{logs, setup, solution.structure, soc, solution.rates};
  const Held held = SolveWithoutEach(fit, sweep, logs.Pieces(), {solution.smoothness});
  const auto percent = [&](const std::vector<std::vector<Eigen::VectorXd>>& unknowns,
                           std::vector<double>* always = nullptr) {
    return SumErrors(sweep, logs.Pieces(), unknowns, ErrorSize::kPercentOfRows, always)[0];
  };
  // Ends of discharges and slow ones are in no group: of them the fitted errors count.
  std::vector<double> always(logs.logs.size(), 0.0);
  const std::vector<double> fitted = percent(std::vector(held.without.size(), held.whole), &always);
  const std::vector<double> left_out = percent(held.without);

  // Rows of each unit.
  std::vector<double> size(logs.unit_weight.size(), 0.0);
  for (const JointLog& log : logs.logs) {
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (log.group[k] != JointLog::kAlways)
        size[static_cast<std::size_t>(log.unit[k])] += log.count[k];
    }
  }
  // Every log counts the same, and within it every row.
  std::vector<double> share(size.size(), 0.0);
  double stays = 0.0;
  double by_noise = 0.0;
  for (std::size_t l = 0; l < logs.logs.size(); ++l) {
    const JointLog& log = logs.logs[l];
    double rows = 0.0;
    for (const double count : log.count) rows += count;
    double own = always[l];
    for (std::size_t k = 0; k < log.size(); ++k) {
      if (log.group[k] == JointLog::kAlways) continue;
      const auto u = static_cast<std::size_t>(log.unit[k]);
      share[u] += log.count[k] / rows;
      own += fitted[u] / size[u] * log.count[k];
    }
    stays += always[l] / rows;
    by_noise += own / rows * trust.new_over_fitted[l];
  }
  const auto seen = static_cast<double>(logs.logs.size());
  std::vector<double> mean(size.size(), 0.0);
  double sum = 0.0;
  double shares = 0.0;
  double count = 0.0;
  for (std::size_t u = 0; u < share.size(); ++u) {
    if (share[u] <= 0.0) continue;
    share[u] /= seen;
    mean[u] = (kFitted * fitted[u] + (1.0 - kFitted) * left_out[u]) / size[u];
    sum += share[u] * mean[u];
    shares += share[u];
    count += 1.0;
  }
  double squares = 0.0;
  for (std::size_t u = 0; u < share.size(); ++u)
    squares += std::pow(share[u] * (mean[u] - sum / shares), 2);
  expected.percent = std::max(sum + stays / seen, by_noise / seen);
  if (count < 2.0) return expected;
  const double by_units = Reach95(count - 1.0) * std::sqrt(squares * count / (count - 1.0));
  const double by_simulation = Reach95(kSimulations - 1.0) * trust.new_over_fitted_spread;
  const double reach = std::hypot(by_units, by_simulation * expected.percent);
  expected.low_percent = std::max(expected.percent - reach, 0.0);
  expected.high_percent = expected.percent + reach;
  return expected;
}

}  // namespace lipoid
