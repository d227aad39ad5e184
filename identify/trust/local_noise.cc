#include "identify/trust/local_noise.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

// The mean square to expect of the mean of n rows: of noise that differs from row to row, which the
// differences of neighbours show, an n-th, and all of what is slower.
Eigen::VectorXd Expected(const Eigen::VectorXd& residual_V, const Eigen::VectorXd& count) {
  const Eigen::Index n = residual_V.size();
  const Eigen::VectorXd parts = count.cwiseInverse();
  const double all = residual_V.squaredNorm() / static_cast<double>(n);
  if (n < 2) return Eigen::VectorXd::Constant(n, all);
  const double differences = (residual_V.tail(n - 1) - residual_V.head(n - 1)).squaredNorm();
  const double white =
      std::min(differences / (parts.head(n - 1) + parts.tail(n - 1)).sum(), all / parts.mean());
  return (white * parts).array() + (all - white * parts.mean());
}

}  // namespace

Eigen::VectorXd LocalNoise(const std::vector<double>& time_s,
                           const Eigen::VectorXd& residual_V,
                           const Eigen::VectorXd& averaged) {
  constexpr double kReach = 1.0 / 16.0;  // of the duration, to either side
  constexpr double kPrior = 3.0;
  const Eigen::Index n = residual_V.size();
  const Eigen::VectorXd count = averaged.size() > 0 ? averaged : Eigen::VectorXd::Ones(n).eval();
  if (!(residual_V.squaredNorm() > 0.0)) return Eigen::VectorXd::Ones(n);
  // In units of what is expected, so that what a window loses and wins is of one size.
  const Eigen::VectorXd square =
      residual_V.cwiseAbs2().cwiseQuotient(Expected(residual_V, count)).cwiseProduct(count);
  const double reach_s = kReach * (time_s.back() - time_s.front());
  Eigen::VectorXd local(n);
  double sum = 0.0;
  double rows = 0.0;
  double changes = 0.0;
  const auto changes_sign = [&](Eigen::Index k) {
    return k > 0 && (residual_V[k] > 0.0) != (residual_V[k - 1] > 0.0) ? 1.0 : 0.0;
  };
  Eigen::Index first = 0;
  Eigen::Index end = 0;
  const auto at_s = [&](Eigen::Index k) { return time_s[static_cast<std::size_t>(k)]; };
  for (Eigen::Index k = 0; k < n; ++k) {
    for (; end < n && at_s(end) <= at_s(k) + reach_s; ++end) {
      sum += square[end];
      rows += count[end];
      changes += changes_sign(end);
    }
    for (; at_s(first) < at_s(k) - reach_s; ++first) {
      sum -= square[first];
      rows -= count[first];
      changes -= changes_sign(first);
    }
    // What rounding has left of a large square must not pass for a small one.
    constexpr double kLeast = 1e-6;
    local[k] = std::pow(std::max(sum / rows, kLeast), changes / (changes + kPrior));
  }
  local *= count.sum() / local.dot(count);
  return local.cwiseSqrt();
}

}  // namespace lipoid
