#include "identify/health/trend.h"

#include <Eigen/Dense>
#include <cmath>

#include "model/statistics/quantiles.h"

namespace lipoid {

std::optional<HealthTrend> FitTrend(std::span<const TrendPoint> points) {
  constexpr std::size_t kFewest = 3;
  if (points.size() < kFewest) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(points.size());
  const double span = points.back().at - points.front().at;
  Eigen::MatrixXd line(n, 2);  // the logarithms at the first and at the last
  Eigen::VectorXd log_value(n);
  Eigen::VectorXd weight(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const TrendPoint& point = points[static_cast<std::size_t>(k)];
    const double share = (point.at - points.front().at) / span;
    line.row(k) << 1.0 - share, share;
    log_value[k] = std::log(point.value);
    weight[k] = 1.0 / (point.log_deviation * point.log_deviation);
  }
  const Eigen::Matrix2d inverse = (line.transpose() * weight.asDiagonal() * line).inverse();
  const Eigen::Vector2d ends = inverse * (line.transpose() * weight.asDiagonal() * log_value);
  const Eigen::VectorXd off = log_value - line * ends;
  const double freedom = static_cast<double>(n) - 2.0;
  const double scatter = (weight.array() * off.array().square()).sum() / freedom;
  const Eigen::Matrix2d covariance = scatter * inverse;
  const double reach = Reach95(freedom);
  // Of exp(slope' ends), less `less`.
  const auto interval = [&](const Eigen::Vector2d& slope, double less, double factor) {
    const double log_at = slope.dot(ends);
    const double half = reach * std::sqrt(slope.dot(covariance * slope));
    const auto at = [&](double log) { return factor * (std::exp(log) - less); };
    return WithInterval{at(log_at), at(log_at - half), at(log_at + half), {}};
  };
  const Eigen::Vector2d ratio(-1.0, 1.0);
  return HealthTrend{.flights = points.size(),
                     .first = interval(Eigen::Vector2d::UnitX(), 0.0, 1.0),
                     .last = interval(Eigen::Vector2d::UnitY(), 0.0, 1.0),
                     .change_percent = interval(ratio, 1.0, 100.0),
                     .per_flight_percent = interval(ratio, 1.0, 100.0 / span)};
}

}  // namespace lipoid
