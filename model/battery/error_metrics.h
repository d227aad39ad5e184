#pragma once

/// @file
/// How far a prediction is from a measurement.
///
///   e(k)  = 100 |(x(k) - x^(k))/x(k)| %   (4.56)
///   e_avg = mean of e                     (4.57)
///   e_max = maximum of e                  (4.58)
///
/// and the root mean square of x - x^. Every row counts once, or by its share of time.
/// Tests: tests/model/battery/error_metrics_test.cc.

#include <cmath>
#include <cstddef>
#include <limits>

namespace lipoid {

/// NaN until a row was added.
struct ErrorMetrics {
  double mean_error_percent = std::numeric_limits<double>::quiet_NaN();
  double max_error_percent = std::numeric_limits<double>::quiet_NaN();
  double rmse = std::numeric_limits<double>::quiet_NaN();  ///< in the unit of x
  std::size_t rows = 0;
};

class ErrorAccumulator {
 public:
  /// measured must not be zero (voltages and times are not); weight >= 0.
  void Add(double measured, double predicted, double weight = 1.0) {
    const double error = measured - predicted;
    const double percent = 100.0 * std::abs(error / measured);  // (4.56)
    // Not std::max: a NaN must not vanish, not even behind later rows.
    if (percent > largest_ || std::isnan(percent)) largest_ = percent;
    percent_ += weight * percent;
    squares_ += weight * error * error;
    weight_ += weight;
    ++rows_;
  }

  [[nodiscard]] ErrorMetrics Result() const {
    if (rows_ == 0) return {};
    return {.mean_error_percent = percent_ / weight_,  // (4.57)
            .max_error_percent = largest_,             // (4.58)
            .rmse = std::sqrt(squares_ / weight_),
            .rows = rows_};
  }

 private:
  double percent_ = 0.0;
  double squares_ = 0.0;
  double largest_ = 0.0;
  double weight_ = 0.0;
  std::size_t rows_ = 0;
};

}  // namespace lipoid
