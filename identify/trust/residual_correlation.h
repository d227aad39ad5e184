#pragma once

/// @file
/// How the residuals of one log are correlated in time, whatever its sampling.
///
///   C(dt) = white² [dt = 0]/n + sum_m a_m² exp(-|dt|/T_m),   a_m² >= 0
///
/// n is the number of log rows whose mean a row is. The time constants T_m are a fixed grid from
/// the sampling to the length of the log, so that the model is linear in the variances white²,
/// a_m², which are what is found. They are fitted to the variogram
///
///   gamma(h) = mean of (r(t + h) - r(t))²/2,  h = the lags,   and the mean of r² as the last one
///
/// with relative weights: short lags tell fast noise from slow noise even where the slow one is
/// much larger, which the autocovariance cannot. A residual lacks what the fit has followed of the
/// noise: what is left of each component is the design to fit with (trust.cc). Tests:
/// tests/identify/trust/residual_correlation_test.cc.

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace lipoid {

/// What a reader wants to know of it.
struct ResidualCorrelation {
  double white_V = 0.0;       ///< independent from row to row
  double correlated_V = 0.0;  ///< sqrt of sum a_m²
  double correlation_s =
      0.0;  ///< until that part has fallen to 1/e; infinite: an offset, NaN: none
};

class CorrelationModel {
 public:
  /// Rising times of the rows; `averaged` is n of each row, empty: 1.
  CorrelationModel(const std::vector<double>& time_s, Eigen::VectorXd averaged);
  /// The same with one time constant: for noise that is known, or assumed.
  CorrelationModel(const std::vector<double>& time_s,
                   Eigen::VectorXd averaged,
                   double time_constant_s);

  /// white first, then one for each time constant.
  [[nodiscard]] Eigen::Index components() const { return 1 + TimeConstants(); }
  [[nodiscard]] const std::vector<double>& time_constant_s() const { return time_constant_s_; }

  /// The variogram of each series: series x rows in, lags x series out.
  [[nodiscard]] Eigen::MatrixXd Variogram(const Eigen::MatrixXd& series) const;
  /// What each component of unit variance should give there: lags x components.
  [[nodiscard]] const Eigen::MatrixXd& design() const { return design_; }
  /// The variances, one per component, whose variogram by this design is nearest.
  [[nodiscard]] Eigen::VectorXd Fit(const Eigen::VectorXd& variogram,
                                    const Eigen::MatrixXd& design) const;

  /// Noise of these variances, series x rows. The same seed and stream give the same noise, and
  /// each component its own, scaled by its standard deviation.
  [[nodiscard]] Eigen::MatrixXd Simulate(const Eigen::VectorXd& variances,
                                         Eigen::Index series,
                                         std::uint64_t seed,
                                         std::uint32_t stream) const;

  /// sum_ij s_i s_j' C(t_i - t_j) for unit variance of one component; s is a column per row. One
  /// recurrence along the rows, not a double sum.
  [[nodiscard]] Eigen::MatrixXd QuadraticSum(const Eigen::MatrixXd& scores,
                                             Eigen::Index component) const;

  /// The same for all components at these variances.
  [[nodiscard]] Eigen::MatrixXd QuadraticSum(const Eigen::MatrixXd& scores,
                                             const Eigen::VectorXd& variances) const;

  [[nodiscard]] ResidualCorrelation Describe(const Eigen::VectorXd& variances) const;

 private:
  struct Lag {
    std::vector<std::int32_t> first, second;  // rows of the pairs
    double independent_pairs = 0.0;           // that they are worth
  };

  [[nodiscard]] Eigen::Index TimeConstants() const {
    return static_cast<Eigen::Index>(time_constant_s_.size());
  }
  [[nodiscard]] Eigen::Index Rows() const { return averaged_.size(); }

  Eigen::VectorXd step_s_;    // to a row from the one before; 0 of the first
  Eigen::VectorXd averaged_;  // n
  std::vector<double> time_constant_s_;
  std::vector<Lag> lags_;
  Eigen::MatrixXd design_;  // lags and the mean square x components: their variograms
  Eigen::VectorXd worth_;   // of each line of it
};

}  // namespace lipoid
