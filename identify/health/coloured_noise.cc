#include "identify/health/coloured_noise.h"

#include <cmath>

namespace lipoid {

double ColouredNoise::Whiten(const std::vector<double>& time_s, Eigen::MatrixXd& columns) const {
  const auto states = static_cast<Eigen::Index>(slow.size());
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(states, states);
  Eigen::ArrayXd variance(states);
  for (Eigen::Index m = 0; m < states; ++m) {
    const double deviation_V = slow[static_cast<std::size_t>(m)].deviation_V;
    variance[m] = deviation_V * deviation_V;
    covariance(m, m) = variance[m];
  }
  Eigen::MatrixXd state = Eigen::MatrixXd::Zero(states, columns.cols());
  Eigen::ArrayXd decay(states);
  Eigen::VectorXd gain(states);
  Eigen::RowVectorXd innovation(columns.cols());
  double log_determinant = 0.0;
  for (Eigen::Index k = 0; k < columns.rows(); ++k) {
    const auto row = static_cast<std::size_t>(k);
    if (k > 0) {
      for (Eigen::Index m = 0; m < states; ++m) {
        decay[m] = std::exp(-(time_s[row] - time_s[row - 1]) /
                            slow[static_cast<std::size_t>(m)].time_constant_s);
      }
      state.array().colwise() *= decay;
      covariance = (decay.matrix() * decay.matrix().transpose()).cwiseProduct(covariance);
      covariance.diagonal().array() += variance * (1.0 - decay.square());
    }
    gain = covariance.rowwise().sum();
    const double spread_V2 = gain.sum() + white_V * white_V;
    innovation = columns.row(k) - state.colwise().sum();
    log_determinant += std::log(spread_V2);
    columns.row(k) = innovation / std::sqrt(spread_V2);
    state += (gain / spread_V2) * innovation;
    covariance -= gain * gain.transpose() / spread_V2;
  }
  return log_determinant;
}

}  // namespace lipoid
