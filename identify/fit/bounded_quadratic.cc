#include "identify/fit/bounded_quadratic.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// Solves G_FF x_F = g_F - G_FA x_A for the free unknowns F; false where G_FF is not positive
// definite. Those of A stand at their bounds.
bool SolveFree(const Eigen::MatrixXd& G,
               const Eigen::VectorXd& g,
               const std::vector<char>& active,
               Eigen::VectorXd& x) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    if (!active[k]) free.push_back(k);
  }
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd G_FF(n, n);
  Eigen::VectorXd right(n);
  for (Eigen::Index b = 0; b < n; ++b) {
    for (Eigen::Index a = b; a < n; ++a) G_FF(a, b) = G(free[a], free[b]);
    right[b] = g[free[b]];
  }
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    if (!active[k] || x[k] == 0.0) continue;
    for (Eigen::Index a = 0; a < n; ++a) {
      right[a] -= (free[a] >= k ? G(free[a], k) : G(k, free[a])) * x[k];
    }
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(G_FF);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(right);
  for (Eigen::Index a = 0; a < n; ++a) x[free[a]] = right[a];
  return right.allFinite();
}

// How far the multiplier of an active bound pulls inwards, beyond what rounding may do to it.
double PullInwards(double g, double gradient, char active) {
  const double noise = 1e-13 * (std::abs(g) + std::abs(gradient));
  return (g - gradient) * (active == 1 ? 1.0 : -1.0) - noise;
}

// Exchanges of many bounds at once may go round in circles. This takes one bound at a time, from a
// point within all of them, and never rises: it ends.
void WalkDown(const Eigen::MatrixXd& G,
              const Eigen::VectorXd& g,
              const Eigen::VectorXd& lower,
              const Eigen::VectorXd& upper,
              BoundedQuadraticResult& result) {
  const Eigen::Index n = g.size();
  Eigen::VectorXd& x = result.x;
  std::vector<char>& active = result.active;
  x = x.cwiseMax(lower).cwiseMin(upper);
  for (Eigen::Index k = 0; k < n; ++k) {
    if (active[k]) x[k] = active[k] == 1 ? lower[k] : upper[k];
  }
  const int most = result.factorizations + 20 * static_cast<int>(n);
  while (result.factorizations < most) {
    ++result.factorizations;
    Eigen::VectorXd target = x;
    if (!SolveFree(G, g, active, target)) return;
    double share = 1.0;  // of the way to the target
    Eigen::Index stops = -1;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (active[k] || (target[k] >= lower[k] && target[k] <= upper[k])) continue;
      const double bound = target[k] < lower[k] ? lower[k] : upper[k];
      const double until = (bound - x[k]) / (target[k] - x[k]);
      if (stops >= 0 && until >= share) continue;
      share = until;
      stops = k;
    }
    if (stops >= 0) {
      active[stops] = target[stops] < lower[stops] ? 1 : 2;
      x += share * (target - x);
      x = x.cwiseMax(lower).cwiseMin(upper);
      x[stops] = active[stops] == 1 ? lower[stops] : upper[stops];
      continue;
    }
    x = target;
    const Eigen::VectorXd gradient = G.selfadjointView<Eigen::Lower>() * x;
    Eigen::Index worst = -1;
    double pull = 0.0;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (!active[k] || lower[k] == upper[k]) continue;
      const double inwards = PullInwards(g[k], gradient[k], active[k]);
      if (inwards > pull) {
        pull = inwards;
        worst = k;
      }
    }
    result.solved = worst < 0;
    if (result.solved) return;
    active[worst] = 0;
  }
}

}  // namespace

BoundedQuadraticResult MinimizeBoundedQuadratic(const Eigen::MatrixXd& G,
                                                const Eigen::VectorXd& g,
                                                const Eigen::VectorXd& lower,
                                                const std::vector<char>& guess,
                                                const Eigen::VectorXd& upper) {
  const Eigen::Index n = g.size();
  Require(G.rows() == n && G.cols() == n && lower.size() == n &&
              (upper.size() == 0 || upper.size() == n),
          "a quadratic of one size",
          {{"n", static_cast<double>(n)}, {"rows", static_cast<double>(G.rows())}});
  constexpr int kPatience = 3;  // exchanges of all that disagree which need not bring progress
  BoundedQuadraticResult result;
  result.x = Eigen::VectorXd::Zero(n);
  result.active = guess.empty() ? std::vector<char>(n, 0) : guess;
  const auto most_of = [&](Eigen::Index k) {
    return upper.size() == 0 ? std::numeric_limits<double>::infinity() : upper[k];
  };
  const auto is_held = [&](Eigen::Index k) { return lower[k] == most_of(k); };
  for (Eigen::Index k = 0; k < n; ++k) {
    if (lower[k] > most_of(k)) return result;
    char& active = result.active[static_cast<std::size_t>(k)];
    if (is_held(k)) {
      active = 1;
    } else if (std::isinf(active == 1 ? lower[k] : active == 2 ? most_of(k) : 0.0)) {
      active = 0;
    }
  }
  // What rounding may do to a bound and to a gradient.
  const double x_scale = g.size() > 0 ? 1e-12 : 0.0;
  Eigen::Index fewest = n + 1;
  int patience = kPatience;
  const int most = 50 + 5 * static_cast<int>(n);
  std::vector<Eigen::Index> wrong;
  std::vector<char> other;  // what they change to
  Eigen::VectorXd gradient(n);
  while (result.factorizations < most) {
    ++result.factorizations;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (result.active[k]) result.x[k] = result.active[k] == 1 ? lower[k] : upper[k];
    }
    if (!SolveFree(G, g, result.active, result.x)) return result;
    gradient.noalias() = G.selfadjointView<Eigen::Lower>() * result.x;
    wrong.clear();
    other.clear();
    const auto beyond = [&](double bound) { return x_scale * (1.0 + std::abs(bound)); };
    for (Eigen::Index k = 0; k < n; ++k) {
      if (is_held(k)) continue;
      char instead = result.active[k];
      if (result.active[k]) {
        if (PullInwards(g[k], gradient[k], result.active[k]) > 0.0) instead = 0;
      } else if (result.x[k] < lower[k] - beyond(lower[k])) {
        instead = 1;
      } else if (result.x[k] > most_of(k) + beyond(most_of(k))) {
        instead = 2;
      }
      if (instead == result.active[k]) continue;
      wrong.push_back(k);
      other.push_back(instead);
    }
    if (wrong.empty()) {
      for (Eigen::Index k = 0; k < n; ++k)
        result.x[k] = std::min(std::max(result.x[k], lower[k]), most_of(k));
      result.solved = true;
      return result;
    }
    const auto count = static_cast<Eigen::Index>(wrong.size());
    if (count < fewest) {
      fewest = count;
      patience = kPatience;
    } else if (--patience < 0) {
      wrong = {wrong.back()};
      other = {other.back()};
    }
    for (std::size_t w = 0; w < wrong.size(); ++w) result.active[wrong[w]] = other[w];
  }
  const Eigen::VectorXd no_upper =
      Eigen::VectorXd::Constant(n, std::numeric_limits<double>::infinity());
  WalkDown(G, g, lower, upper.size() == 0 ? no_upper : upper, result);
  return result;
}

}  // namespace lipoid
