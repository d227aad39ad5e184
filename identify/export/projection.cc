#include "identify/export/projection.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "identify/optimizers/least_squares.h"
#include "identify/optimizers/optimizers.h"
#include "model/core/errors.h"
#include "model/core/stop.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

// Parameters in units of their scales; slopes by central differences, whose step is far above the
// rounding of a voltage and far below the width of any piece of a table.
class ProjectionProblem : public LeastSquaresProblem {
 public:
  ProjectionProblem(const ProjectedLaw& law,
                    std::span<const double> voltage_V,
                    const std::vector<FreeParameter>& parameters)
      : law_(law), voltage_V_(voltage_V), parameters_(parameters) {}

  [[nodiscard]] int size() const override { return static_cast<int>(parameters_.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override { return Bound(&FreeParameter::lower); }
  [[nodiscard]] Eigen::VectorXd upper() const override { return Bound(&FreeParameter::upper); }

  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override {
    constexpr double kStep = 1e-5;
    const Eigen::Index n = x.size();
    const auto rows = static_cast<Eigen::Index>(voltage_V_.size());
    const Eigen::VectorXd truth =
        Eigen::Map<const Eigen::VectorXd>(voltage_V_.data(), rows) * RowScale();
    if (!jacobian) {
      Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(n + 1, 1);
      factor(n, 0) = (Volts(x) - truth).norm();
      return factor;
    }
    Eigen::MatrixXd all(rows, n + 1);
    for (Eigen::Index k = 0; k < n; ++k) {
      Eigen::VectorXd above = x;
      Eigen::VectorXd below = x;
      above[k] = std::min(x[k] + kStep, upper()[k]);
      below[k] = std::max(x[k] - kStep, lower()[k]);
      const double width = above[k] - below[k];
      all.col(k) = width > 0.0 ? Eigen::VectorXd((Volts(above) - Volts(below)) / width)
                               : Eigen::VectorXd::Zero(rows);
    }
    all.col(n) = Volts(x) - truth;
    if (!all.allFinite())
      return Eigen::MatrixXd::Constant(n + 1, n + 1, std::numeric_limits<double>::quiet_NaN());
    if (rows < n + 1) {  // fewer rows than unknowns: the factor keeps its shape
      Eigen::MatrixXd padded = Eigen::MatrixXd::Zero(n + 1, n + 1);
      padded.topRows(rows) = all;
      all = std::move(padded);
    }
    return TriangularFactor(all);
  }

  [[nodiscard]] Eigen::VectorXd Scaled(const std::vector<double>& values) const {
    Eigen::VectorXd x(size());
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const auto& p = parameters_[static_cast<std::size_t>(k)];
      x[k] = std::clamp(values[static_cast<std::size_t>(k)], p.lower, p.upper) / p.scale;
    }
    return x;
  }
  [[nodiscard]] std::vector<double> Values(const Eigen::VectorXd& x) const {
    std::vector<double> values(parameters_.size());
    for (std::size_t k = 0; k < values.size(); ++k) {
      const auto& p = parameters_[k];
      values[k] = std::clamp(x[static_cast<Eigen::Index>(k)] * p.scale, p.lower, p.upper);
    }
    return values;
  }

 private:
  // Residuals are those of the mean row, so that a cost means the same for any length.
  [[nodiscard]] double RowScale() const {
    return 1.0 / std::sqrt(static_cast<double>(voltage_V_.size()));
  }
  [[nodiscard]] Eigen::VectorXd Volts(const Eigen::VectorXd& x) const {
    StopIfAsked();
    const std::vector<double> volts = law_(Values(x));
    return Eigen::Map<const Eigen::VectorXd>(volts.data(),
                                             static_cast<Eigen::Index>(volts.size())) *
           RowScale();
  }
  [[nodiscard]] Eigen::VectorXd Bound(double FreeParameter::*bound) const {
    Eigen::VectorXd values(size());
    for (Eigen::Index k = 0; k < values.size(); ++k) {
      const auto& p = parameters_[static_cast<std::size_t>(k)];
      values[k] = p.*bound / p.scale;
    }
    return values;
  }

  const ProjectedLaw& law_;
  std::span<const double> voltage_V_;
  const std::vector<FreeParameter>& parameters_;
};

}  // namespace

Projection Project(const ProjectedLaw& law,
                   std::span<const double> voltage_V,
                   const std::vector<FreeParameter>& parameters,
                   const std::vector<std::vector<double>>& starts) {
  Require(!starts.empty(), "at least one start");
  const ProjectionProblem problem(law, voltage_V, parameters);
  const OptimizerEntry& optimizer = FindOptimizer("levenberg-marquardt");
  OptimizationSummary best;
  for (const auto& start : starts) {
    Require(start.size() == parameters.size(),
            "a start for every parameter",
            {{"start", static_cast<double>(start.size())}});
    OptimizationSummary found = optimizer.Minimize(problem, problem.Scaled(start));
    if (std::isfinite(found.cost) && !(found.cost >= best.cost)) best = std::move(found);
  }
  Projection projection;
  if (!std::isfinite(best.cost)) {
    projection.termination = Termination::kFailure;
    projection.message = "No start has a finite error.";
    return projection;
  }
  projection.parameters = problem.Values(best.x);
  projection.termination = best.termination;
  projection.message = best.message;
  for (std::size_t k = 0; k < parameters.size(); ++k) {
    const auto& p = parameters[k];
    const double value = projection.parameters[k];
    const double near = 1e-9 * p.scale;
    if (p.lower < p.upper && (value - p.lower <= near || p.upper - value <= near))
      projection.at_bound.push_back(p.name);
  }
  return projection;
}

}  // namespace lipoid
