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
  Eigen::MatrixXd line(n, 2);  // the values at the first and at the last
  Eigen::VectorXd value(n);
  Eigen::VectorXd weight(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const TrendPoint& point = points[static_cast<std::size_t>(k)];
    const double share = (point.at - points.front().at) / span;
    line.row(k) << 1.0 - share, share;
    value[k] = point.value;
    const double deviation = point.value * point.log_deviation;
    weight[k] = 1.0 / (deviation * deviation);
  }
  const Eigen::Matrix2d inverse = (line.transpose() * weight.asDiagonal() * line).inverse();
  const Eigen::Vector2d ends = inverse * (line.transpose() * weight.asDiagonal() * value);
  const Eigen::VectorXd off = value - line * ends;
  const double freedom = static_cast<double>(n) - 2.0;
  const double scatter = (weight.array() * off.array().square()).sum() / freedom;
  const Eigen::Matrix2d covariance = scatter * inverse;
  const double reach = Reach95(freedom);
  const auto interval = [&](double at, const Eigen::Vector2d& slope, double factor) {
    const double half = reach * std::sqrt(slope.dot(covariance * slope));
    return WithInterval{factor * at, factor * (at - half), factor * (at + half), {}};
  };
  const double change = ends[1] / ends[0] - 1.0;
  const Eigen::Vector2d of_change(-ends[1] / (ends[0] * ends[0]), 1.0 / ends[0]);
  return HealthTrend{.flights = points.size(),
                     .first = interval(ends[0], Eigen::Vector2d::UnitX(), 1.0),
                     .last = interval(ends[1], Eigen::Vector2d::UnitY(), 1.0),
                     .change_percent = interval(change, of_change, 100.0),
                     .per_flight_percent = interval(change, of_change, 100.0 / span)};
}

}  // namespace lipoid
