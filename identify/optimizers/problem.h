#pragma once

/// @file
/// What every optimizer here minimizes: a cost of a few bounded parameters.
///
///   minimize cost(x)  with  lower <= x <= upper
///
/// Parameters are what the optimizer moves: scaled, of order one. A bound of kUnbounded is none;
/// equal bounds fix a parameter. The cost may be NaN where the model has no value, and may throw:
/// either is a point that is not taken. Cost() may be called by several threads at once.
/// Least squares hand out more than this: LeastSquaresProblem.

#include <Eigen/Core>
#include <limits>

namespace lipoid {

/// Bounds from 1e300 on are none.
constexpr double kUnbounded = std::numeric_limits<double>::max();
constexpr bool IsBound(double bound) { return bound > -1e300 && bound < 1e300; }

class OptimizationProblem {
 public:
  virtual ~OptimizationProblem() = default;

  [[nodiscard]] virtual int size() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd lower() const = 0;
  [[nodiscard]] virtual Eigen::VectorXd upper() const = 0;

  [[nodiscard]] virtual double Cost(const Eigen::VectorXd& x) const = 0;

  /// Whether Gradient() may be asked.
  [[nodiscard]] virtual bool has_gradient() const { return true; }

  /// The cost, and its exact gradient (size n).
  virtual double Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) const = 0;
};

}  // namespace lipoid
