#pragma once

/// @file
/// (4.53) as a problem that every optimizer takes: the squared errors of the times that constant
/// currents last, over the logarithms of the lag c = pi²/(3 beta²) and of alpha, so that both stay
/// positive. The steady form L = alpha/I - c also has a closed form, which FitDischargeTimes()
/// uses; the exact one solves (4.37) for every time. Tests:
/// tests/identify/stages/discharge_times_problem_test.cc.

#include <limits>
#include <optional>
#include <vector>

#include "identify/optimizers/least_squares.h"
#include "identify/stages/discharge_times.h"

namespace lipoid {

inline constexpr double kLargestBeta = 1.0;  ///< (4.53)

/// 1 or 1/L, times the root of the weight of its square.
[[nodiscard]] double TimeWeight(const DischargeTime& discharge, TimeWeighting weighting);

class DischargeTimesProblem : public LeastSquaresProblem {
 public:
  /// The discharges, with positive currents and times, must outlive this. A finite `decades` is
  /// half the width of a box around Start(), for those that search one.
  DischargeTimesProblem(const std::vector<DischargeTime>& discharges,
                        const DischargeTimesOptions& options,
                        std::optional<double> given_alpha_C = std::nullopt,
                        double decades = std::numeric_limits<double>::infinity());

  /// log c, and log alpha where it is not given.
  [[nodiscard]] int size() const override { return given_alpha_C_ ? 1 : 2; }
  [[nodiscard]] Eigen::VectorXd lower() const override;
  [[nodiscard]] Eigen::VectorXd upper() const override;
  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override;

  /// alpha is the largest charge that was delivered, beta kTypicalBeta.
  [[nodiscard]] Eigen::VectorXd Start() const;
  [[nodiscard]] Eigen::VectorXd Point(double alpha_C, double lag_s) const;
  [[nodiscard]] double Alpha(const Eigen::VectorXd& x) const;  ///< C
  [[nodiscard]] double Lag(const Eigen::VectorXd& x) const;    ///< s

 private:
  const std::vector<DischargeTime>& discharges_;
  DischargeTimesOptions options_;
  std::optional<double> given_alpha_C_;
  double decades_;
};

}  // namespace lipoid
