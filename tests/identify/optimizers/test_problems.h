#pragma once

/// @file
/// Problems with known answers for the tests of optimizers. Each records what it was asked.

#include <Eigen/Dense>
#include <algorithm>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "identify/optimizers/least_squares.h"
#include "model/core/special_values.h"
#include "tests/identify/optimizers/nist_problems.h"

namespace lipoid::test {

/// What a problem was asked, from any thread.
class Questions {
 public:
  void Add(const Eigen::VectorXd& x, bool gradient) const {
    const std::lock_guard lock(state_->mutex);
    state_->points.push_back(x);
    if (gradient) ++state_->gradients;
  }
  [[nodiscard]] const std::vector<Eigen::VectorXd>& points() const { return state_->points; }
  [[nodiscard]] int gradients() const { return state_->gradients; }

 private:
  struct State {
    std::mutex mutex;
    std::vector<Eigen::VectorXd> points;
    int gradients = 0;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
};

/// Bounds and a record, for least squares and for any cost alike.
template <class Base>
class RecordedProblem : public Base {
 public:
  explicit RecordedProblem(int size)
      : lower_(Eigen::VectorXd::Constant(size, -kUnbounded)),
        upper_(Eigen::VectorXd::Constant(size, kUnbounded)) {}

  void Bound(int k, double lower, double upper) {
    lower_[k] = lower;
    upper_[k] = upper;
  }
  [[nodiscard]] int size() const override { return static_cast<int>(lower_.size()); }
  [[nodiscard]] Eigen::VectorXd lower() const override { return lower_; }
  [[nodiscard]] Eigen::VectorXd upper() const override { return upper_; }

  [[nodiscard]] const Questions& questions() const { return questions_; }
  [[nodiscard]] int evaluations() const { return static_cast<int>(questions_.points().size()); }
  [[nodiscard]] int gradient_evaluations() const { return questions_.gradients(); }

  /// Was asked beyond the bounds.
  [[nodiscard]] bool outside() const {
    return std::any_of(questions_.points().begin(), questions_.points().end(), [&](const auto& x) {
      return (x.array() < lower_.array()).any() || (x.array() > upper_.array()).any();
    });
  }

 private:
  Eigen::VectorXd lower_, upper_;
  Questions questions_;
};

/// Any residuals and Jacobian as a problem: the triangular factor by a QR of [J r].
class DenseProblem : public RecordedProblem<LeastSquaresProblem> {
 public:
  /// Fills r and, where it is not null, J.
  using Function =
      std::function<void(const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd* j)>;

  DenseProblem(int size, Function function)
      : RecordedProblem(size), function_(std::move(function)) {}

  DenseProblem& Bound(int k, double lower, double upper) {
    RecordedProblem::Bound(k, lower, upper);
    return *this;
  }

  /// The residuals, and their Jacobian where it is not null.
  void Rows(const Eigen::VectorXd& x, Eigen::VectorXd& r, Eigen::MatrixXd* j) const {
    function_(x, r, j);
  }

  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool jacobian) const override {
    questions().Add(x, jacobian);
    const int n = size();
    Eigen::VectorXd r;
    Eigen::MatrixXd j;
    function_(x, r, jacobian ? &j : nullptr);
    Eigen::MatrixXd factor = Eigen::MatrixXd::Zero(n + 1, n + 1);
    if (!jacobian) {
      factor(n, n) = r.norm();
      return factor;
    }
    Eigen::MatrixXd all = Eigen::MatrixXd::Zero(std::max<Eigen::Index>(r.size(), n + 1), n + 1);
    all.topLeftCorner(r.size(), n) = j;
    all.topRightCorner(r.size(), 1) = r;
    if (!all.allFinite()) return Eigen::MatrixXd::Constant(n + 1, n + 1, kNaN);
    const Eigen::HouseholderQR<Eigen::MatrixXd> qr(all);
    return qr.matrixQR().topRows(n + 1).triangularView<Eigen::Upper>();
  }

 private:
  Function function_;
};

/// A cost that is no sum of squares, with its gradient or without.
class CostProblem : public RecordedProblem<OptimizationProblem> {
 public:
  /// Returns the cost; fills the gradient where it is not null.
  using Function = std::function<double(const Eigen::VectorXd& x, Eigen::VectorXd* gradient)>;

  CostProblem(int size, bool has_gradient, Function function)
      : RecordedProblem(size), has_gradient_(has_gradient), function_(std::move(function)) {}

  [[nodiscard]] double Cost(const Eigen::VectorXd& x) const override {
    questions().Add(x, false);
    return function_(x, nullptr);
  }
  [[nodiscard]] bool has_gradient() const override { return has_gradient_; }
  double Gradient(const Eigen::VectorXd& x, Eigen::VectorXd& gradient) const override {
    questions().Add(x, true);
    return function_(x, &gradient);
  }

 private:
  bool has_gradient_;
  Function function_;
};

inline DenseProblem MakeNistProblem(const NistProblem& nist) {
  const auto n = static_cast<Eigen::Index>(nist.certified.size());
  return DenseProblem(static_cast<int>(n), [&nist, n](const auto& x, auto& r, auto* j) {
    const auto rows = static_cast<Eigen::Index>(nist.x.size());
    r.resize(rows);
    if (j != nullptr) j->resize(rows, n);
    std::vector<NistJet> b;
    for (int k = 0; k < n; ++k) b.emplace_back(x[k], k);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const auto at = static_cast<std::size_t>(k);
      const NistJet predicted = nist.model(b, nist.x[at]);
      r[k] = nist.y[at] - predicted.a;
      if (j != nullptr) j->row(k) = -predicted.v.head(n).transpose();
    }
  });
}

/// r = A x - b.
inline DenseProblem LinearProblem(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  return DenseProblem(static_cast<int>(a.cols()), [a, b](const auto& x, auto& r, auto* j) {
    r = a * x - b;
    if (j != nullptr) *j = a;
  });
}

/// The valley of Rosenbrock, minimum 0 at (1, 1).
inline DenseProblem Rosenbrock() {
  return DenseProblem(2, [](const auto& x, auto& r, auto* j) {
    r = Eigen::Vector2d(10.0 * (x[1] - x[0] * x[0]), 1.0 - x[0]);
    if (j != nullptr) {
      j->resize(2, 2);
      *j << -20.0 * x[0], 10.0, -1.0, 0.0;
    }
  });
}

}  // namespace lipoid::test
