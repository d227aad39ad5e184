#include "identify/joint/leave_out.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <numeric>

namespace lipoid {

LeftOutErrors LeaveOut(const JointFit& fit,
                       const JointLogs& logs,
                       const JointStructure& structure,
                       const JointRates& rates,
                       const std::vector<double>& ladder) {
  LeftOutErrors best;
  if (!ladder.empty()) best.smoothness = ladder[ladder.size() / 2];
  if (logs.groups < 2) return best;
  const JointSetup& setup = fit.seen().setup();
  const SocTrace soc = TraceSoc(logs, setup, rates.beta_per_sqrt_s);
  const auto sums = SumGroups(logs, setup, structure, soc, rates);
  NormalEquations total = sums.back();
  double weight = 0.0;
  for (int g = 0; g < logs.groups; ++g) {
    total.Add(sums[g]);
    weight += sums[g].weight;
  }
  const auto groups = static_cast<std::size_t>(logs.groups);
  std::vector<Eigen::VectorXd> whole;
  std::vector<std::vector<char>> guess;  // what holds with all rows mostly holds without some
  for (const double smoothness : ladder) {
    JointSolution solution = fit.SolveSums(
        structure, rates, smoothness, total, guess.empty() ? std::vector<char>{} : guess.back());
    whole.push_back(std::move(solution.x));
    guess.push_back(std::move(solution.active));
  }
  // without[g][s]: the unknowns that the other groups give.
  std::vector<std::vector<Eigen::VectorXd>> without(groups);
  tbb::parallel_for(std::size_t{0}, groups, [&](std::size_t g) {
    NormalEquations rest = total;
    rest.Add(sums[g], -1.0);
    for (std::size_t s = 0; s < ladder.size(); ++s)
      without[g].push_back(fit.SolveSums(structure, rates, ladder[s], rest, guess[s]).x);
  });
  const auto total_of = [&](const std::vector<double>& units) {
    return std::accumulate(units.begin(), units.end(), 0.0) / weight;
  };
  const auto fitted = SumErrors(logs,
                                setup,
                                structure,
                                soc,
                                rates,
                                std::vector<std::vector<Eigen::VectorXd>>(groups, whole));
  const auto errors = SumErrors(logs, setup, structure, soc, rates, without);
  constexpr double kFitted = 0.368;  // e^-1: the share of rows that a bootstrap leaves out
  std::vector<LeftOutErrors> all;
  for (std::size_t s = 0; s < ladder.size(); ++s) {
    LeftOutErrors& one = all.emplace_back();
    one.smoothness = ladder[s];
    one.fitted_V = total_of(fitted[s]);
    one.left_out_V = total_of(errors[s]);
    one.expected_V = kFitted * one.fitted_V + (1.0 - kFitted) * one.left_out_V;
    for (std::size_t u = 0; u < errors[s].size(); ++u)
      one.unit_V.push_back(kFitted * fitted[s][u] + (1.0 - kFitted) * errors[s][u]);
  }
  double least_V = std::numeric_limits<double>::infinity();
  for (const LeftOutErrors& one : all) least_V = std::min(least_V, one.expected_V);
  for (const LeftOutErrors& one : all) {
    if (one.expected_V <= (1.0 + kSmoothnessLoss) * least_V) return one;
  }
  return best;
}

}  // namespace lipoid
