#include "identify/logs/thermometer_noise.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <optional>

#include "model/core/parallel.h"
#include "model/statistics/order_statistics.h"

namespace lipoid {
namespace {

constexpr std::size_t kLeastReach = 2;
constexpr std::size_t kMostReach = 128;
// Standard deviations, beyond which a difference is no chance.
constexpr double kChance = 3.0;

struct Parabola {
  double here = 0.0;    // in the row that it is about
  double error = 0.0;   // its standard deviation where the noise is 1
  double square = 0.0;  // of the residuals, mean per degree of freedom
  double freedom = 0.0;
};

// Least squares through rows first .. last about one of them.
std::optional<Parabola> Fit(std::span<const double> time_s,
                            std::span<const double> shown,
                            std::size_t row,
                            std::size_t first,
                            std::size_t last) {
  const auto rows = static_cast<double>(last - first + 1);
  const double scale_s = std::max(time_s[row] - time_s[first], time_s[last] - time_s[row]);
  if (!(scale_s > 0.0)) return std::nullopt;
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  double sum2 = 0.0;
  for (std::size_t k = first; k <= last; ++k) {
    const double u = (time_s[k] - time_s[row]) / scale_s;
    const double y = shown[k] - shown[row];
    const Eigen::Vector3d powers(1.0, u, u * u);
    square += powers * powers.transpose();
    right += y * powers;
    sum2 += y * y;
  }
  const Eigen::LDLT<Eigen::Matrix3d> factor(square);
  const Eigen::Vector3d found = factor.solve(right);
  if (!found.allFinite()) return std::nullopt;
  const double freedom = rows - 3.0;
  return Parabola{.here = shown[row] + found[0],
                  .error = std::sqrt(factor.solve(Eigen::Vector3d::UnitX())[0]),
                  .square = std::max(sum2 - right.dot(found), 0.0) / freedom,
                  .freedom = freedom};
}

}  // namespace

double ThermometerNoise(std::span<const double> shown) {
  constexpr std::size_t kFewest = 30;
  if (shown.size() < kFewest) return 0.0;
  std::vector<double> differences;
  for (std::size_t k = 1; k + 1 < shown.size(); ++k)
    differences.push_back(std::abs(shown[k + 1] - 2.0 * shown[k] + shown[k - 1]));
  constexpr double kMedianOfNormal = 0.6745;
  return Median(std::move(differences)) / (kMedianOfNormal * std::sqrt(6.0));
}

std::vector<double> WithoutThermometerNoise(std::span<const double> time_s,
                                            std::span<const double> shown,
                                            double noise) {
  std::vector<double> smooth(shown.begin(), shown.end());
  // Of long logs less, down to eight rows to either side.
  constexpr std::size_t kMostWork = 16'000'000;
  const std::size_t most_reach =
      std::clamp<std::size_t>(kMostWork / std::max<std::size_t>(shown.size(), 1), 8, kMostReach);
  const auto smooth_one = [&](std::size_t row) {
    double error = 1.5;  // of the row itself, which may be one of many that is far off
    for (std::size_t reach = kLeastReach; reach <= most_reach; reach *= 2) {
      const std::size_t first = row - std::min(row, reach);
      const std::size_t last = std::min(row + reach, shown.size() - 1);
      if (last - first < 2 * kLeastReach) continue;
      const auto wider = Fit(time_s, shown, row, first, last);
      // Rows that lie on no parabola; few may have one that is far off among them.
      if (!wider ||
          wider->square > noise * noise * (1.0 + kChance * std::sqrt(2.0 / wider->freedom)))
        continue;
      // A parabola that has left what fewer rows say.
      if (std::abs(wider->here - smooth[row]) > kChance * error * noise) break;
      smooth[row] = wider->here;
      error = wider->error;
    }
  };
  constexpr std::size_t kRowsAtOnce = 4096;
  ParallelFor(shown.size() / kRowsAtOnce + 1, [&](std::size_t block) {
    const std::size_t end = std::min((block + 1) * kRowsAtOnce, shown.size());
    for (std::size_t row = block * kRowsAtOnce; row < end; ++row) smooth_one(row);
  });
  return smooth;
}

}  // namespace lipoid
