#include <Eigen/Dense>
#include <algorithm>
#include <boost/math/tools/minima.hpp>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "identify/stages/curve_forms.h"
#include "identify/stages/row_factor.h"

namespace lipoid {
namespace {

// The mean of neighbouring rows, and how many there were. A smooth curve of a few dozen
// coefficients is straight to 1e-6 V over a ten-thousandth of its range, so nothing is lost and
// millions of rows are few.
struct WeightedPoint {
  double soc, voltage_V, weight;
};

std::vector<WeightedPoint> Compress(const CurveRows& points, const Share& share) {
  constexpr std::size_t kMost = 10000;
  const std::size_t group = std::max<std::size_t>(1, points.size() / kMost);
  std::vector<WeightedPoint> means;
  for (std::size_t first = 0; first < points.size(); first += group) {
    WeightedPoint sum{0.0, 0.0, 0.0};
    for (std::size_t k = first; k < std::min(points.size(), first + group); ++k) {
      if (!share.Has(k)) continue;
      sum.soc += points.soc[k];
      sum.voltage_V += points.voltage_V[k];
      sum.weight += 1.0;
    }
    if (sum.weight > 0.0)
      means.push_back({sum.soc / sum.weight, sum.voltage_V / sum.weight, sum.weight});
  }
  return means;
}

// Least squares over the coefficients of `columns` basis functions; norm receives ||residual||.
template <class Basis>
Eigen::VectorXd FitBasis(const std::vector<WeightedPoint>& points,
                         int columns,
                         Basis&& basis,
                         double* norm) {
  RowFactor rows(columns + 1);
  Eigen::VectorXd values(columns);
  for (const WeightedPoint& point : points) {
    basis(point.soc, values);
    const double weight = std::sqrt(point.weight);
    double* row = rows.NextRow();
    for (int j = 0; j < columns; ++j) row[j * rows.stride()] = weight * values[j];
    row[columns * rows.stride()] = weight * point.voltage_V;
    rows.Push();
  }
  const Eigen::MatrixXd factor = rows.Factor();
  // Harmonics over less than a period are nearly dependent: the smallest solution is the tame one.
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> solver;
  solver.setThreshold(1e-12);
  solver.compute(factor.topLeftCorner(columns, columns));
  const Eigen::VectorXd right = factor.topRightCorner(columns, 1);
  Eigen::VectorXd solution = solver.solve(right);
  if (norm != nullptr) {
    *norm = std::hypot((factor.topLeftCorner(columns, columns) * solution - right).norm(),
                       factor(columns, columns));
  }
  return solution;
}

}  // namespace

OpenCircuitVoltage FitPolynomial(const CurveRows& rows, const Share& shown, int degree) {
  const double lo = rows.lo;
  const double hi = rows.hi;
  const auto chebyshev = [&](double soc, Eigen::VectorXd& t) {
    const double x = (2.0 * soc - lo - hi) / (hi - lo);
    t[0] = 1.0;
    t[1] = x;
    for (int k = 2; k <= degree; ++k) t[k] = 2.0 * x * t[k - 1] - t[k - 2];
  };
  const Eigen::VectorXd c = FitBasis(Compress(rows, shown), degree + 1, chebyshev, nullptr);
  return OpenCircuitVoltage::Polynomial(lo, hi, {c.begin(), c.end()});
}

// The frequency is the only nonlinear unknown: a grid finds its valley, Brent's method the bottom.
OpenCircuitVoltage FitFourier(const CurveRows& rows, const Share& shown, int harmonics) {
  const double lo = rows.lo;
  const double hi = rows.hi;
  const std::vector<WeightedPoint> points = Compress(rows, shown);
  const int columns = 2 * harmonics + 1;
  const auto solve = [&](double frequency, double* norm) {
    const auto basis = [&](double soc, Eigen::VectorXd& values) {
      values[0] = 1.0;
      const double c1 = std::cos(frequency * soc);
      const double s1 = std::sin(frequency * soc);
      double c = 1.0;
      double s = 0.0;
      for (int k = 1; k <= harmonics; ++k) {
        const double next = c * c1 - s * s1;
        s = s * c1 + c * s1;
        c = next;
        values[Eigen::Index{2} * k - 1] = c;
        values[Eigen::Index{2} * k] = s;
      }
    };
    return FitBasis(points, columns, basis, norm);
  };
  const auto cost = [&](double frequency) {
    double norm = 0.0;
    static_cast<void>(solve(frequency, &norm));
    return norm;
  };

  constexpr int kGrid = 12;
  const double least = 0.5 * std::numbers::pi / (hi - lo);  // a quarter of a period over the range
  const double most = 2.0 * std::numbers::pi / (hi - lo);   // one period
  const double step = (most - least) / kGrid;
  int best = 0;
  double best_cost = cost(least);
  for (int k = 1; k <= kGrid; ++k) {
    const double here = cost(least + k * step);
    if (here < best_cost) {
      best_cost = here;
      best = k;
    }
  }
  const double frequency =
      boost::math::tools::brent_find_minima(cost,
                                            std::max(least, least + (best - 1) * step),
                                            std::min(most, least + (best + 1) * step),
                                            16)
          .first;
  const Eigen::VectorXd solution = solve(frequency, nullptr);
  std::vector<double> cosine{solution[0]};
  std::vector<double> sine;
  for (int k = 1; k <= harmonics; ++k) {
    cosine.push_back(solution[Eigen::Index{2} * k - 1]);
    sine.push_back(solution[Eigen::Index{2} * k]);
  }
  return OpenCircuitVoltage::Fourier(lo, hi, frequency, std::move(cosine), std::move(sine));
}

}  // namespace lipoid
