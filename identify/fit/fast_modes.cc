#include "identify/fit/fast_modes.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace lipoid {
namespace {

// What is left of a mode after so many of its time constants is a fiftieth.
constexpr double kGone = 4.0;
// The fastest is a hundred times as fast as the first beyond ten: of more of them a part in a hundred is left.
constexpr int kMostModes = 100;

double ShortestStep_s(const LinearizedFit& fit) {
  double shortest_s = std::numeric_limits<double>::infinity();
  for (const FittedRows& log : fit.logs) {
    for (std::size_t k = 1; k < log.time_s.size(); ++k) {
      const double step_s = log.time_s[k] - log.time_s[k - 1];
      if (step_s > 0.0) shortest_s = std::min(shortest_s, step_s);
    }
  }
  return shortest_s;
}

}  // namespace

void AddFastModes(const LinearizedFit& fit,
                  const JointSolution& solution,
                  const JointSetup& setup,
                  double typical_A,
                  const PulseQuestion& question,
                  const std::function<std::vector<FittedRows>(const JointSetup& setup)>& rows_with,
                  FollowedMoves& moves) {
  if (!setup.tail || solution.x.size() == 0) return;
  const double within_s = std::min(ShortestStep_s(fit), question.after_s.front());
  const double wanted = std::ceil(std::sqrt(kGone / within_s) / solution.rates.beta_per_sqrt_s);
  JointSetup finer = setup;
  finer.terms = wanted < kMostModes ? static_cast<int>(wanted) : kMostModes;
  // In the cold they are slower.
  if (solution.structure.temperature) finer.terms = kMostModes;
  if (finer.terms <= setup.terms) return;
  std::vector<double> moved_Ohm = PulseResistancesOf(solution, finer, typical_A, question);
  const auto found_Ohm = PulseResistancesOf(solution, setup, typical_A, question);
  for (std::size_t k = 0; k < moved_Ohm.size(); ++k) moved_Ohm[k] -= found_Ohm[k];
  moves.Add(rows_with(finer), moved_Ohm);
}

}  // namespace lipoid
