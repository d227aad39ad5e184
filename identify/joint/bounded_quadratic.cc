#include "identify/joint/bounded_quadratic.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// Solves G_FF x_F = g_F - G_FA lower_A for the free unknowns F; false where G_FF is not positive
// definite.
bool SolveFree(const Eigen::MatrixXd& G,
               const Eigen::VectorXd& g,
               const Eigen::VectorXd& lower,
               const std::vector<char>& active,
               Eigen::VectorXd& x) {
  std::vector<Eigen::Index> free;
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    if (active[k]) {
      x[k] = lower[k];
    } else {
      free.push_back(k);
    }
  }
  const auto n = static_cast<Eigen::Index>(free.size());
  Eigen::MatrixXd G_FF(n, n);
  Eigen::VectorXd right(n);
  for (Eigen::Index b = 0; b < n; ++b) {
    for (Eigen::Index a = b; a < n; ++a) G_FF(a, b) = G(free[a], free[b]);
    right[b] = g[free[b]];
  }
  for (Eigen::Index k = 0; k < g.size(); ++k) {
    if (!active[k] || lower[k] == 0.0) continue;
    for (Eigen::Index a = 0; a < n; ++a) {
      right[a] -= (free[a] >= k ? G(free[a], k) : G(k, free[a])) * lower[k];
    }
  }
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> factor(G_FF);
  if (factor.info() != Eigen::Success) return false;
  factor.solveInPlace(right);
  for (Eigen::Index a = 0; a < n; ++a) x[free[a]] = right[a];
  return right.allFinite();
}

}  // namespace

BoundedQuadraticResult MinimizeBoundedQuadratic(const Eigen::MatrixXd& G,
                                                const Eigen::VectorXd& g,
                                                const Eigen::VectorXd& lower,
                                                const std::vector<char>& guess,
                                                const std::vector<char>& held) {
  const Eigen::Index n = g.size();
  Require(G.rows() == n && G.cols() == n && lower.size() == n,
          "a quadratic of one size",
          {{"n", static_cast<double>(n)}, {"rows", static_cast<double>(G.rows())}});
  constexpr int kPatience = 3;  // exchanges of all that disagree which need not bring progress
  BoundedQuadraticResult result;
  result.x = Eigen::VectorXd::Zero(n);
  result.active = guess.empty() ? std::vector<char>(n, 0) : guess;
  const auto is_held = [&](Eigen::Index k) { return !held.empty() && held[k] != 0; };
  for (Eigen::Index k = 0; k < n; ++k) {
    if (is_held(k)) {
      result.active[k] = 1;
    } else if (std::isinf(lower[k])) {
      result.active[k] = 0;
    }
  }
  // What rounding may do to a bound and to a gradient.
  const double x_scale = g.size() > 0 ? 1e-12 : 0.0;
  Eigen::Index fewest = n + 1;
  int patience = kPatience;
  const int most = 50 + 5 * static_cast<int>(n);
  std::vector<Eigen::Index> wrong;
  Eigen::VectorXd gradient(n);
  while (result.factorizations < most) {
    ++result.factorizations;
    if (!SolveFree(G, g, lower, result.active, result.x)) return result;
    gradient.noalias() = G.selfadjointView<Eigen::Lower>() * result.x;
    wrong.clear();
    for (Eigen::Index k = 0; k < n; ++k) {
      if (is_held(k)) continue;
      if (result.active[k]) {
        // Its multiplier must not pull inwards.
        const double noise = 1e-13 * (std::abs(g[k]) + std::abs(gradient[k]));
        if (gradient[k] - g[k] < -noise) wrong.push_back(k);
      } else if (result.x[k] < lower[k] - x_scale * (1.0 + std::abs(lower[k]))) {
        wrong.push_back(k);
      }
    }
    if (wrong.empty()) {
      for (Eigen::Index k = 0; k < n; ++k) {
        if (result.x[k] < lower[k]) result.x[k] = lower[k];
      }
      result.solved = true;
      return result;
    }
    const auto count = static_cast<Eigen::Index>(wrong.size());
    if (count < fewest) {
      fewest = count;
      patience = kPatience;
    } else if (--patience < 0) {
      wrong = {wrong.back()};
    }
    for (const Eigen::Index k : wrong) result.active[k] = result.active[k] ? 0 : 1;
  }
  return result;
}

}  // namespace lipoid
