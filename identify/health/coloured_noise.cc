#include "identify/health/coloured_noise.h"

#include <algorithm>
#include <cmath>

namespace lipoid {
namespace {

// What the filter does in each row, whatever the columns hold.
struct Filter {
  Eigen::ArrayXXd decay;   // of each slow process since the row before
  Eigen::ArrayXXd follow;  // what it takes of an innovation
  Eigen::ArrayXd scale;    // of the innovation, to a variance of 1
  double log_determinant = 0.0;
};

Filter FilterOf(const ColouredNoise& noise, const std::vector<double>& time_s) {
  const auto states = static_cast<Eigen::Index>(noise.slow.size());
  const auto rows = static_cast<Eigen::Index>(time_s.size());
  Filter filter{Eigen::ArrayXXd::Ones(states, rows),
                Eigen::ArrayXXd(states, rows),
                Eigen::ArrayXd(rows),
                0.0};
  Eigen::ArrayXd variance(states);
  for (Eigen::Index m = 0; m < states; ++m) {
    const double deviation_V = noise.slow[static_cast<std::size_t>(m)].deviation_V;
    variance[m] = deviation_V * deviation_V;
  }
  Eigen::MatrixXd covariance = variance.matrix().asDiagonal();
  double last_s = -1.0;
  for (Eigen::Index k = 0; k < rows; ++k) {
    if (k > 0) {
      const double dt_s =
          time_s[static_cast<std::size_t>(k)] - time_s[static_cast<std::size_t>(k) - 1];
      for (Eigen::Index m = 0; m < states; ++m) {
        const double tau_s = noise.slow[static_cast<std::size_t>(m)].time_constant_s;
        filter.decay(m, k) = dt_s == last_s ? filter.decay(m, k - 1) : std::exp(-dt_s / tau_s);
      }
      last_s = dt_s;
      const auto decay = filter.decay.col(k);
      for (Eigen::Index b = 0; b < states; ++b) {
        for (Eigen::Index a = 0; a < states; ++a) covariance(a, b) *= decay[a] * decay[b];
        covariance(b, b) += variance[b] * (1.0 - decay[b] * decay[b]);
      }
    }
    auto follow = filter.follow.col(k);
    follow = covariance.rowwise().sum();  // the gain
    const double spread_V2 = follow.sum() + noise.white_V * noise.white_V;
    for (Eigen::Index b = 0; b < states; ++b) {
      for (Eigen::Index a = 0; a < states; ++a)
        covariance(a, b) -= follow[a] * follow[b] / spread_V2;
    }
    follow /= spread_V2;
    filter.scale[k] = 1.0 / std::sqrt(spread_V2);
    filter.log_determinant += std::log(spread_V2);
  }
  return filter;
}

}  // namespace

// Each row of a column waits for the row before it, so that some columns go side by side.
double ColouredNoise::Whiten(const std::vector<double>& time_s, Eigen::MatrixXd& columns) const {
  constexpr Eigen::Index kLanes = 4;
  using Lanes = Eigen::Array<double, kLanes, 1>;
  const Filter filter = FilterOf(*this, time_s);
  const auto states = static_cast<Eigen::Index>(slow.size());
  std::vector<Lanes> state(slow.size());
  for (Eigen::Index first = 0; first < columns.cols(); first += kLanes) {
    const Eigen::Index lanes = std::min(kLanes, columns.cols() - first);
    std::fill(state.begin(), state.end(), Lanes::Zero());
    double* const data = columns.data() + first * columns.outerStride();
    for (Eigen::Index k = 0; k < columns.rows(); ++k) {
      Lanes innovation = Lanes::Zero();
      for (Eigen::Index c = 0; c < lanes; ++c) innovation[c] = data[c * columns.outerStride() + k];
      for (Eigen::Index m = 0; m < states; ++m) {
        state[static_cast<std::size_t>(m)] *= filter.decay(m, k);
        innovation -= state[static_cast<std::size_t>(m)];
      }
      for (Eigen::Index m = 0; m < states; ++m)
        state[static_cast<std::size_t>(m)] += filter.follow(m, k) * innovation;
      innovation *= filter.scale[k];
      for (Eigen::Index c = 0; c < lanes; ++c) data[c * columns.outerStride() + k] = innovation[c];
    }
  }
  return filter.log_determinant;
}

}  // namespace lipoid
