#include "identify/trust/residual_correlation.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "model/core/errors.h"
#include "model/statistics/non_negative.h"
#include "model/statistics/normal_noise.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

// Neighbours of the grid of time constants: two of them stand for any between to a few per cent.
constexpr double kTimeRatio = 2.5;
// Lags grow by this; a pair counts for a lag up to the next one.
constexpr double kLagRatio = 1.5;
// Fewer pairs than this say nothing of a lag.
constexpr std::size_t kLeastPairs = 8;
// The mean square, in independent pairs: it holds the slow parts down, which the longest lags alone
// would leave to chance. Found by the coverage of intervals under noise of 30 and 300 s.
constexpr double kMeanSquareWorth = 20.0;
// An offset is believed where all else leaves so much of the mean square unexplained: little of it
// is chance.
constexpr double kOffsetFrom = 1.5;
// The weights of the fit follow the fitted variogram: a few rounds settle it.
constexpr int kRounds = 5;

// e^{-dt/T} of the last step, which is most often that of the next.
class Decay {
 public:
  explicit Decay(double time_constant_s) : time_constant_s_(time_constant_s) {}
  double operator()(double dt_s) {
    if (dt_s != dt_s_) {
      dt_s_ = dt_s;
      value_ = std::exp(-dt_s / time_constant_s_);
    }
    return value_;
  }

 private:
  double time_constant_s_;
  double dt_s_ = 0.0;
  double value_ = 1.0;
};

}  // namespace

CorrelationModel::CorrelationModel(const std::vector<double>& time_s, Eigen::VectorXd averaged)
    : averaged_(std::move(averaged)) {
  const std::size_t rows = time_s.size();
  if (averaged_.size() == 0) averaged_.setOnes(static_cast<Eigen::Index>(rows));
  Require(static_cast<std::size_t>(averaged_.size()) == rows, "one count for every row");
  step_s_.setZero(Rows());
  for (std::size_t k = 1; k < rows; ++k) {
    step_s_[static_cast<Eigen::Index>(k)] = time_s[k] - time_s[k - 1];
    Require(time_s[k] > time_s[k - 1], "rising times", {{"time_s", time_s[k]}});
  }
  if (rows > 1) {
    // The shortest steps that are more than an exception.
    std::vector<double> steps(step_s_.data() + 1, step_s_.data() + rows);
    const double shortest_s = ValueAtPlace(steps, steps.size() / 10);
    const double span_s = time_s.back() - time_s.front();
    for (double tau_s = 2.0 * shortest_s; tau_s <= span_s; tau_s *= kTimeRatio)
      time_constant_s_.push_back(tau_s);
    // An offset of all rows is noise, too, and in no difference of rows.
    time_constant_s_.push_back(std::numeric_limits<double>::infinity());
    for (double lag_s = shortest_s; lag_s <= 0.5 * span_s; lag_s *= kLagRatio) {
      Lag lag;
      double sum_s = 0.0;
      const double from_s = lag_s * (1.0 - 1e-9);
      for (std::size_t k = 0, j = 0; k < rows; ++k) {
        while (j < rows && time_s[j] - time_s[k] < from_s) ++j;
        if (j == rows) break;
        const double between_s = time_s[j] - time_s[k];
        if (between_s >= from_s * kLagRatio) continue;
        lag.first.push_back(static_cast<std::int32_t>(k));
        lag.second.push_back(static_cast<std::int32_t>(j));
        sum_s += between_s;
      }
      const auto pairs = static_cast<double>(lag.first.size());
      if (lag.first.size() < kLeastPairs) continue;
      // Pairs that overlap repeat themselves where the noise is slow.
      lag.independent_pairs = std::min(pairs, 2.0 * span_s / lag_s);
      Eigen::RowVectorXd line(components());
      double white = 0.0;
      for (std::size_t k = 0; k < lag.first.size(); ++k)
        white += 0.5 * (1.0 / averaged_[lag.first[k]] + 1.0 / averaged_[lag.second[k]]);
      line[0] = white / pairs;
      for (Eigen::Index m = 0; m < TimeConstants(); ++m)
        line[1 + m] = -std::expm1(-sum_s / pairs / time_constant_s_[static_cast<std::size_t>(m)]);
      lags_.push_back(std::move(lag));
      design_.conservativeResize(static_cast<Eigen::Index>(lags_.size()), components());
      design_.bottomRows(1) = line;
    }
  }
  design_.conservativeResize(design_.rows() + 1, components());
  design_.bottomRows(1).setOnes();
  design_(design_.rows() - 1, 0) = rows > 0 ? averaged_.cwiseInverse().mean() : 1.0;
  worth_.resize(design_.rows());
  for (std::size_t k = 0; k < lags_.size(); ++k)
    worth_[static_cast<Eigen::Index>(k)] = lags_[k].independent_pairs;
  worth_[design_.rows() - 1] = kMeanSquareWorth;
}

CorrelationModel::CorrelationModel(const std::vector<double>& time_s,
                                   Eigen::VectorXd averaged,
                                   double time_constant_s)
    : CorrelationModel(time_s, std::move(averaged)) {
  Require(time_constant_s > 0.0, "time_constant_s > 0", {{"time_constant_s", time_constant_s}});
  time_constant_s_ = {time_constant_s};
  lags_.clear();
  design_.setOnes(1, components());
  worth_.setOnes(1);
}

Eigen::MatrixXd CorrelationModel::Variogram(const Eigen::MatrixXd& series) const {
  Require(series.cols() == Rows(), "as many values as rows");
  Eigen::MatrixXd variogram(design_.rows(), series.rows());
  for (std::size_t l = 0; l < lags_.size(); ++l) {
    const Lag& lag = lags_[l];
    Eigen::ArrayXd sum = Eigen::ArrayXd::Zero(series.rows());
    for (std::size_t k = 0; k < lag.first.size(); ++k)
      sum += (series.col(lag.second[k]) - series.col(lag.first[k])).array().square();
    variogram.row(static_cast<Eigen::Index>(l)) = 0.5 / static_cast<double>(lag.first.size()) * sum;
  }
  variogram.bottomRows(1) =
      series.rowwise().squaredNorm().transpose() / std::max(1.0, static_cast<double>(Rows()));
  return variogram;
}

Eigen::VectorXd CorrelationModel::Fit(const Eigen::VectorXd& variogram,
                                      const Eigen::MatrixXd& design) const {
  Require(variogram.size() == design_.rows() && design.rows() == design_.rows() &&
              design.cols() == design_.cols(),
          "a variogram and a design of this log");
  Eigen::VectorXd found = Eigen::VectorXd::Zero(components());
  const double largest = variogram.maxCoeff();
  if (!(largest > 0.0)) return found;
  const Eigen::Index last = variogram.size() - 1;
  Eigen::MatrixXd columns = design;
  columns.rightCols(TimeConstants() > 0 ? 1 : 0).setZero();
  const auto fit = [&] {
    Eigen::VectorXd near = variogram;
    for (int round = 0; round < kRounds; ++round) {
      near = near.cwiseMax(1e-9 * largest);
      const Eigen::VectorXd weight = worth_.cwiseSqrt().cwiseQuotient(near);
      found =
          NonNegativeLeastSquares(weight.asDiagonal() * columns, weight.cwiseProduct(variogram));
      near = columns * found;
    }
    return near[last];
  };
  if (variogram[last] > kOffsetFrom * fit() && TimeConstants() > 0) {
    columns.rightCols(1) = design.rightCols(1);
    fit();
  }
  return found;
}

Eigen::MatrixXd CorrelationModel::Simulate(const Eigen::VectorXd& variances,
                                           Eigen::Index series,
                                           std::uint64_t seed,
                                           std::uint32_t stream) const {
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(series, Rows());
  Eigen::ArrayXd state(series);
  for (Eigen::Index m = 0; m < components(); ++m) {
    if (!(variances[m] > 0.0)) continue;
    const double sigma = std::sqrt(variances[m]);
    NormalNoise normal(seed, stream * 64U + static_cast<std::uint32_t>(m));
    Decay decay(m > 0 ? time_constant_s_[static_cast<std::size_t>(m - 1)] : 1.0);
    for (Eigen::Index k = 0; k < Rows(); ++k) {
      const double kept = m == 0 || k == 0 ? 0.0 : decay(step_s_[k]);
      const double fresh =
          m == 0 ? sigma / std::sqrt(averaged_[k]) : sigma * std::sqrt((1.0 - kept) * (1.0 + kept));
      for (Eigen::Index s = 0; s < series; ++s)
        state[s] = (kept == 0.0 ? 0.0 : kept * state[s]) + fresh * normal();
      noise.col(k).array() += state;
    }
  }
  return noise;
}

Eigen::MatrixXd CorrelationModel::QuadraticSum(const Eigen::MatrixXd& scores,
                                               Eigen::Index component) const {
  Require(scores.cols() == Rows(), "as many scores as rows");
  if (component == 0) return scores * averaged_.cwiseInverse().asDiagonal() * scores.transpose();
  // c_k = sum_{j < k} s_j e^{-(t_k - t_j)/T}
  Eigen::MatrixXd before = Eigen::MatrixXd::Zero(scores.rows(), scores.cols());
  Decay decay(time_constant_s_[static_cast<std::size_t>(component - 1)]);
  for (Eigen::Index k = 1; k < Rows(); ++k)
    before.col(k) = decay(step_s_[k]) * (before.col(k - 1) + scores.col(k - 1));
  const Eigen::MatrixXd half = scores * before.transpose();
  Eigen::MatrixXd sum = scores * scores.transpose() + half;
  sum += half.transpose();
  return sum;
}

Eigen::MatrixXd CorrelationModel::QuadraticSum(const Eigen::MatrixXd& scores,
                                               const Eigen::VectorXd& variances) const {
  Require(scores.cols() == Rows() && variances.size() == components(),
          "as many scores as rows, and a variance for each component");
  // Half of each row's own square, and all of those before it: one product for all components.
  const double slow = variances.tail(TimeConstants()).sum();
  const Eigen::VectorXd own =
      0.5 * (variances[0] * averaged_.cwiseInverse().array() + slow).matrix();
  Eigen::MatrixXd half = scores * own.asDiagonal();
  Eigen::VectorXd before(scores.rows());
  for (Eigen::Index m = 0; m < TimeConstants(); ++m) {
    if (!(variances[1 + m] > 0.0)) continue;
    Decay decay(time_constant_s_[static_cast<std::size_t>(m)]);
    before.setZero();
    for (Eigen::Index k = 1; k < Rows(); ++k) {
      before = decay(step_s_[k]) * (before + scores.col(k - 1));
      half.col(k) += variances[1 + m] * before;
    }
  }
  const Eigen::MatrixXd sum = scores * half.transpose();
  return sum + sum.transpose();
}

ResidualCorrelation CorrelationModel::Describe(const Eigen::VectorXd& variances) const {
  ResidualCorrelation correlation;
  correlation.white_V = std::sqrt(variances[0]);
  const auto covariance = [&](double dt_s) {
    double sum = 0.0;
    for (Eigen::Index m = 1; m < components(); ++m)
      sum += variances[m] * std::exp(-dt_s / time_constant_s_[static_cast<std::size_t>(m - 1)]);
    return sum;
  };
  const double all = covariance(0.0);
  correlation.correlated_V = std::sqrt(all);
  correlation.correlation_s = std::numeric_limits<double>::quiet_NaN();
  if (!(all > 0.0)) return correlation;
  double shorter_s = 0.0;
  double longer_s = 2.0 * step_s_.sum();
  for (int halvings = 0; halvings < 60; ++halvings) {
    const double middle_s = 0.5 * (shorter_s + longer_s);
    (covariance(middle_s) > all / std::exp(1.0) ? shorter_s : longer_s) = middle_s;
  }
  correlation.correlation_s = covariance(longer_s) > all / std::exp(1.0)
                                  ? std::numeric_limits<double>::infinity()
                                  : longer_s;
  return correlation;
}

}  // namespace lipoid
