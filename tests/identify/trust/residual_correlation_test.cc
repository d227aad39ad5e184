#include "identify/trust/residual_correlation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "model/statistics/normal_noise.h"

namespace lipoid {
namespace {

// Rows every second, then every ten, then every tenth of a second.
std::vector<double> UnevenTimes(int each) {
  std::vector<double> time_s{0.0};
  for (const double step_s : {1.0, 10.0, 0.1}) {
    for (int k = 0; k < each; ++k) time_s.push_back(time_s.back() + step_s);
  }
  return time_s;
}

std::vector<double> EvenTimes(int rows) {
  std::vector<double> time_s;
  for (int k = 0; k < rows; ++k) time_s.push_back(k);
  return time_s;
}

TEST(ResidualCorrelation, RecurrenceEqualsTheDoubleSum) {
  const auto time_s = UnevenTimes(40);
  const auto rows = static_cast<Eigen::Index>(time_s.size());
  NormalNoise normal(1, 0);
  Eigen::VectorXd averaged(rows);
  Eigen::MatrixXd scores(3, rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    averaged[k] = 1.0 + static_cast<double>(k % 4);
    for (Eigen::Index q = 0; q < 3; ++q) scores(q, k) = normal();
  }
  const CorrelationModel model(time_s, averaged);
  for (Eigen::Index m = 0; m < model.components(); ++m) {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, 3);
    for (Eigen::Index i = 0; i < rows; ++i) {
      for (Eigen::Index j = 0; j < rows; ++j) {
        const double dt_s =
            std::abs(time_s[static_cast<std::size_t>(i)] - time_s[static_cast<std::size_t>(j)]);
        const double c =
            m == 0 ? (i == j ? 1.0 / averaged[i] : 0.0)
                   : std::exp(-dt_s / model.time_constant_s()[static_cast<std::size_t>(m - 1)]);
        sum += c * scores.col(i) * scores.col(j).transpose();
      }
    }
    constexpr double kRounding = 1e-12;  // of sums of 15 000 terms
    EXPECT_LT((model.QuadraticSum(scores, m) - sum).norm(), kRounding * sum.norm()) << m;
  }
  // Several at once: each times its variance.
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(model.components());
  variances[0] = 0.3;
  variances[2] = 2.0;
  variances[variances.size() - 1] = 0.7;
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(3, 3);
  for (Eigen::Index m = 0; m < model.components(); ++m)
    sum += variances[m] * model.QuadraticSum(scores, m);
  EXPECT_LT((model.QuadraticSum(scores, variances) - sum).norm(), 1e-12 * sum.norm());
}

// By a generator of its own: x(k+1) = a x(k) + sqrt(1 - a²) z.
TEST(ResidualCorrelation, FindsWhiteAndSlowNoiseOfVeryDifferentSize) {
  constexpr int kRows = 40000;
  constexpr double kWhite_V = 1e-4;
  constexpr double kSlow_V = 1e-3;
  constexpr double kTime_s = 100.0;
  NormalNoise normal(7, 0);
  Eigen::RowVectorXd series(kRows);
  const double kept = std::exp(-1.0 / kTime_s);
  double state = normal();
  for (int k = 0; k < kRows; ++k) {
    series[k] = kWhite_V * normal() + kSlow_V * state;
    state = kept * state + std::sqrt(1.0 - kept * kept) * normal();
  }
  const CorrelationModel model(EvenTimes(kRows), {});
  const auto found = model.Describe(model.Fit(model.Variogram(series), model.design()));
  // 200 correlation times give a standard deviation to 5 %. The white part, a tenth of the other,
  // is known by the first lags: slow noise moves by 0.14 mV from row to row.
  EXPECT_NEAR(found.white_V, kWhite_V, 0.1 * kWhite_V);
  EXPECT_NEAR(found.correlated_V, kSlow_V, 0.15 * kSlow_V);
  EXPECT_GT(found.correlation_s, 0.5 * kTime_s);
  EXPECT_LT(found.correlation_s, 2.0 * kTime_s);
}

TEST(ResidualCorrelation, SimulatesTheCovarianceAskedFor) {
  const auto time_s = UnevenTimes(6);
  const auto rows = static_cast<Eigen::Index>(time_s.size());
  const CorrelationModel model(time_s, {});
  Eigen::VectorXd variances = Eigen::VectorXd::Zero(model.components());
  variances[0] = 0.5;
  variances[2] = 2.0;
  constexpr Eigen::Index kSeries = 20000;
  const Eigen::MatrixXd noise = model.Simulate(variances, kSeries, 3, 0);
  const Eigen::MatrixXd sample = noise.transpose() * noise / double(kSeries);
  for (Eigen::Index i = 0; i < rows; ++i) {
    for (Eigen::Index j = 0; j < rows; ++j) {
      const double dt_s =
          std::abs(time_s[static_cast<std::size_t>(i)] - time_s[static_cast<std::size_t>(j)]);
      const double c = (i == j ? 0.5 : 0.0) + 2.0 * std::exp(-dt_s / model.time_constant_s()[1]);
      EXPECT_NEAR(sample(i, j), c, 5.0 * 2.5 * std::sqrt(2.0 / double(kSeries))) << i << " " << j;
    }
  }
}

TEST(ResidualCorrelation, MeansOfRowsHaveLessWhiteNoise) {
  constexpr int kRows = 5000;
  Eigen::VectorXd averaged(kRows);
  Eigen::RowVectorXd series(kRows);
  NormalNoise normal(5, 0);
  for (int k = 0; k < kRows; ++k) {
    averaged[k] = k % 2 == 0 ? 1.0 : 16.0;
    series[k] = normal() / std::sqrt(averaged[k]);
  }
  const CorrelationModel model(EvenTimes(kRows), averaged);
  const auto found = model.Describe(model.Fit(model.Variogram(series), model.design()));
  EXPECT_NEAR(found.white_V, 1.0, 0.05);  // 2500 single rows: 1/sqrt(5000) = 1.4 %
  EXPECT_LT(found.correlated_V, 0.1);
}

// An error of all rows alike is in no difference of rows, but it is an error.
TEST(ResidualCorrelation, CountsAnOffsetAsSlowNoise) {
  constexpr int kRows = 1000;
  NormalNoise normal(9, 0);
  Eigen::RowVectorXd series(kRows);
  for (int k = 0; k < kRows; ++k) series[k] = 2.0 + 0.1 * normal();
  const CorrelationModel model(EvenTimes(kRows), {});
  const auto found = model.Describe(model.Fit(model.Variogram(series), model.design()));
  EXPECT_NEAR(found.white_V, 0.1, 0.01);
  EXPECT_NEAR(found.correlated_V, 2.0, 0.02);
  EXPECT_EQ(found.correlation_s, std::numeric_limits<double>::infinity());
}

TEST(ResidualCorrelation, TakesTheShortestLogs) {
  for (const int rows : {0, 1, 2, 3, 10}) {
    SCOPED_TRACE(rows);
    const CorrelationModel model(EvenTimes(rows), {});
    Eigen::RowVectorXd series(rows);
    for (int k = 0; k < rows; ++k) series[k] = k % 2 == 0 ? 2.0 : -2.0;
    const auto found = model.Describe(model.Fit(model.Variogram(series), model.design()));
    EXPECT_NEAR(std::hypot(found.white_V, found.correlated_V), rows > 0 ? 2.0 : 0.0, 0.3);
    const auto none = model.Fit(model.Variogram(0.0 * series), model.design());
    EXPECT_TRUE(none.isZero(0.0));
  }
}

}  // namespace
}  // namespace lipoid
