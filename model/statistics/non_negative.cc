#include "model/statistics/non_negative.h"

#include <algorithm>
#include <vector>

#include "model/statistics/factorizations.h"

namespace lipoid {

Eigen::VectorXd NonNegativeLeastSquares(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  const Eigen::Index n = a.cols();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n);
  std::vector<bool> active(static_cast<std::size_t>(n), false);
  const double tolerance = 1e-12 * (a.transpose() * b).cwiseAbs().maxCoeff();
  for (int rounds = 0; rounds < 3 * static_cast<int>(n); ++rounds) {
    const Eigen::VectorXd slope = a.transpose() * (b - a * x);
    Eigen::Index enters = -1;
    for (Eigen::Index k = 0; k < n; ++k) {
      if (!active[static_cast<std::size_t>(k)] && slope[k] > tolerance &&
          (enters < 0 || slope[k] > slope[enters]))
        enters = k;
    }
    if (enters < 0) break;
    active[static_cast<std::size_t>(enters)] = true;
    while (true) {
      std::vector<Eigen::Index> free;
      for (Eigen::Index k = 0; k < n; ++k) {
        if (active[static_cast<std::size_t>(k)]) free.push_back(k);
      }
      if (free.empty()) break;
      const Eigen::VectorXd y = LeastSquares(a(Eigen::all, free), b);
      double share = 1.0;
      for (std::size_t k = 0; k < free.size(); ++k) {
        const double to = y[static_cast<Eigen::Index>(k)];
        if (to <= 0.0) share = std::min(share, x[free[k]] / (x[free[k]] - to));
      }
      for (std::size_t k = 0; k < free.size(); ++k) {
        double& value = x[free[k]];
        value += share * (y[static_cast<Eigen::Index>(k)] - value);
        if (share < 1.0 && value <= 1e-15 * x.maxCoeff()) {
          value = 0.0;
          active[static_cast<std::size_t>(free[k])] = false;
        }
      }
      if (share >= 1.0) break;
    }
  }
  return x.cwiseMax(0.0);
}

}  // namespace lipoid
