#include "model/battery/uncertain_cell.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "model/battery/cell_parameters.h"
#include "model/battery/charge_axis.h"
#include "model/core/errors.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

// Of the estimate.
constexpr double kLeastPositive = 0.01;

// The coordinate of beta, and its slope.
double HeldBack(double beta_per_sqrt_s) { return 1.0 / (beta_per_sqrt_s * beta_per_sqrt_s); }
double HeldBackSlope(double beta_per_sqrt_s) {
  return -2.0 * HeldBack(beta_per_sqrt_s) / beta_per_sqrt_s;
}
double BetaOf(double held_back_s) { return 1.0 / std::sqrt(held_back_s); }

Eigen::MatrixXd AsMatrix(const std::vector<std::vector<double>>& rows) {
  const auto n = static_cast<Eigen::Index>(rows.size());
  Eigen::MatrixXd matrix(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j)
      matrix(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
  }
  return 0.5 * (matrix + matrix.transpose());
}

// With each coordinate in the unit in which its variance is 1.
struct Eigensystem {
  explicit Eigensystem(const Eigen::MatrixXd& covariance)
      : unit(covariance.diagonal().cwiseSqrt()) {
    const Eigen::VectorXd per_unit =
        (unit.array() > 0.0).select(unit.cwiseInverse(), 0.0 * unit).eval();
    eigen = EigenOfSymmetric(per_unit.asDiagonal() * covariance * per_unit.asDiagonal());
  }

  Eigen::VectorXd unit;
  SymmetricEigen eigen;
};

// The covariance C of all where some, N, are known: C - C_N C_NN^-1 C_N'.
Eigen::MatrixXd WhereKnown(const Eigen::MatrixXd& covariance,
                           const std::vector<Eigen::Index>& known) {
  Eigen::MatrixXd left = covariance;
  if (known.empty()) return left;
  const auto [unit, eigen] = Eigensystem(covariance(known, known));
  for (Eigen::Index axis = 0; axis < eigen.values.size(); ++axis) {
    if (!(eigen.values[axis] > kCovarianceRounding)) continue;
    const Eigen::VectorXd per_unit =
        (unit.array() > 0.0).select(eigen.vectors.col(axis).cwiseQuotient(unit), 0.0);
    const Eigen::VectorXd with = covariance(Eigen::all, known) * per_unit;
    left.noalias() -= with * with.transpose() / eigen.values[axis];
  }
  return left;
}

bool IsNode(std::string_view name) { return name.find('[') != std::string_view::npos; }

// The kind of a parameter, or of the resistance that a node belongs to; null for a node of v_oc.
const CellParameterKind* KindOf(std::string_view name) {
  const auto found = FindCellParameter(name.substr(0, name.find('[')));
  return found ? found->kind : nullptr;
}

}  // namespace

UncertainCell::UncertainCell(const Cell& cell) : base_(cell) {
  Require(cell.uncertainty.has_value(), "a cell with its uncertainty");
  const Cell::Uncertainty& uncertainty = *cell.uncertainty;
  names_ = uncertainty.parameters;
  freedom_ = uncertainty.degrees_of_freedom;
  soc_follows_alpha_ = uncertainty.soc_follows_alpha;
  base_.run.reset();
  base_.uncertainty.reset();
  covariance_ = AsMatrix(uncertainty.covariance);
  estimate_.resize(covariance_.rows());
  for (Eigen::Index k = 0; k < estimate_.size(); ++k) {
    const auto value = CellParameter(cell, Name(k));
    Require(value.has_value(), "an uncertainty of parameters that the cell has");
    estimate_[k] = *value;
    kinds_.push_back(KindOf(Name(k)));
    if (Name(k) != "beta") continue;
    estimate_[k] = HeldBack(*value);
    covariance_.row(k) *= HeldBackSlope(*value);
    covariance_.col(k) *= HeldBackSlope(*value);
  }
  const auto [unit, eigen] = Eigensystem(covariance_);
  factor_ = unit.asDiagonal() * eigen.vectors * eigen.values.cwiseMax(0.0).cwiseSqrt().asDiagonal();
  variances_ = eigen.values.cwiseMax(0.0);
  FindRange();
  FindMoves();
}

void UncertainCell::FindRange() {
  const Eigen::Index n = estimate_.size();
  for (const bool node : {false, true}) {
    for (Eigen::Index k = 0; k < n; ++k) {
      if (Kind(k) == nullptr || Kind(k)->any_sign || IsNode(Name(k)) != node) continue;
      range_.push_back({.more = k,
                        .least = Name(k) == "beta" ? HeldBack(Kind(k)->upper)
                                 : Kind(k)->zero   ? 0.0
                                                   : kLeastPositive * estimate_[k]});
    }
    if (!node) of_numbers_ = static_cast<Eigen::Index>(range_.size());
  }
  const auto& voltage_V = base_.open_circuit_voltage.voltage_V();
  node_.assign(voltage_V.size(), -1);
  for (std::size_t node = 0; node < voltage_V.size(); ++node) {
    const auto found =
        std::find(names_.begin(), names_.end(), "v_oc[" + std::to_string(node) + "]");
    if (found != names_.end()) node_[node] = found - names_.begin();
  }
  for (std::size_t node = 0; node + 1 < voltage_V.size(); ++node) {
    Bound rise{.more = node_[node + 1], .less = node_[node], .least = LeastRise(node)};
    if (rise.more < 0) rise.least -= voltage_V[node + 1];
    if (rise.less < 0) rise.least += voltage_V[node];
    if (rise.more >= 0 || rise.less >= 0) range_.push_back(rise);
  }
}

void UncertainCell::FindMoves() {
  std::vector<Eigen::Index> numbers;
  for (Eigen::Index k = 0; k < estimate_.size(); ++k) {
    if (!IsNode(Name(k))) numbers.push_back(k);
  }
  const Eigen::MatrixXd of_nodes = WhereKnown(covariance_, numbers);
  const auto bounds = static_cast<Eigen::Index>(range_.size());
  carried_.setZero(estimate_.size(), bounds);
  variance_.setZero(bounds);
  for (Eigen::Index c = 0; c < bounds; ++c) {
    const Bound& bound = range_[static_cast<std::size_t>(c)];
    const Eigen::MatrixXd& covariance = c < of_numbers_ ? covariance_ : of_nodes;
    double apart = 0.0;
    if (bound.more >= 0) {
      carried_.col(c) += covariance.col(bound.more);
      apart += covariance_(bound.more, bound.more);
    }
    if (bound.less >= 0) {
      carried_.col(c) -= covariance.col(bound.less);
      apart += covariance_(bound.less, bound.less);
    }
    // What does not vary but for rounding cannot be moved.
    const double variance = bound.Of(carried_.col(c));
    if (variance > kCovarianceRounding * apart) variance_[c] = variance;
  }
}

// From a node of v_oc to the next.
double UncertainCell::LeastRise(std::size_t node) const {
  const auto& voltage_V = base_.open_circuit_voltage.voltage_V();
  return std::min(0.0, voltage_V[node + 1] - voltage_V[node]);
}

// To the x within all bounds a . x >= least that minimizes the squared distance by the inverse covariance,
// which is x + covariance a' lambda with lambda >= 0: Hildreth's method moves one lambda at a
// time to where its own bound holds.
bool UncertainCell::MoveIntoRange(Eigen::VectorXd& x) const {
  const bool numbers = Move(x, 0, of_numbers_);
  const bool nodes = Move(x, of_numbers_, variance_.size());
  return numbers || nodes;
}

// By the bounds first .. last - 1.
bool UncertainCell::Move(Eigen::VectorXd& x, Eigen::Index first, Eigen::Index last) const {
  constexpr double kClose = 1e-6;  // of a standard error
  constexpr int kMostSweeps = 10000;
  Eigen::VectorXd lambda = Eigen::VectorXd::Zero(variance_.size());
  const Eigen::VectorXd error = variance_.cwiseSqrt();
  bool moved = false;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double farthest = 0.0;
    for (Eigen::Index c = first; c < last; ++c) {
      if (variance_[c] == 0.0) continue;
      const Bound& bound = range_[static_cast<std::size_t>(c)];
      const double missing = bound.least - bound.Of(x);
      const double step = std::max(-lambda[c], missing / variance_[c]);
      const double standard_errors = std::abs(step) * error[c];
      if (standard_errors <= kClose) continue;
      farthest = std::max(farthest, standard_errors);
      lambda[c] += step;
      x += step * carried_.col(c);
    }
    if (farthest == 0.0) break;
    moved = true;
  }
  return moved;
}

// The range is kept but for rounding, which ends here.
Cell UncertainCell::At(const Eigen::VectorXd& x) const {
  Cell cell = base_;
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    if (Kind(k) == nullptr) continue;
    double value = x[k];
    if (Name(k) == "beta") {
      value = std::min(Kind(k)->upper, BetaOf(std::max(value, HeldBack(Kind(k)->upper))));
    } else if (!Kind(k)->any_sign) {
      value = std::max(Kind(k)->zero ? 0.0 : kLeastPositive * estimate_[k], value);
      if (!Kind(k)->Holds(value)) continue;  // a branch without inertia stays one
    }
    SetCellParameter(cell, Name(k), value);
  }
  SetVoltages(cell, x);
  if (soc_follows_alpha_) MoveChargeAxis(cell, 1.0, base_.alpha_C() / cell.alpha_C());
  return cell;
}

void UncertainCell::SetVoltages(Cell& cell, const Eigen::VectorXd& x) const {
  std::vector<double> voltage_V = base_.open_circuit_voltage.voltage_V();
  for (std::size_t node = 0; node < voltage_V.size(); ++node) {
    if (node_[node] < 0) continue;
    voltage_V[node] = x[node_[node]];
    if (node > 0)
      voltage_V[node] = std::max(voltage_V[node], voltage_V[node - 1] + LeastRise(node - 1));
  }
  for (std::size_t node = voltage_V.size(); node-- > 1;) {
    if (node_[node - 1] < 0) continue;
    voltage_V[node - 1] = std::min(voltage_V[node - 1], voltage_V[node] - LeastRise(node - 1));
  }
  for (std::size_t node = 0; node < voltage_V.size(); ++node) {
    if (node_[node] >= 0) SetCellParameter(cell, Name(node_[node]), voltage_V[node]);
  }
}

Cell::Uncertainty UncertainCell::WithCovariance(const Eigen::VectorXd& x,
                                                const Eigen::MatrixXd& covariance) const {
  Cell::Uncertainty uncertainty{.parameters = names_,
                                .covariance = {},
                                .degrees_of_freedom = freedom_,
                                .soc_follows_alpha = soc_follows_alpha_};
  Eigen::VectorXd unit = Eigen::VectorXd::Ones(x.size());
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    if (Name(k) == "beta") unit[k] = 1.0 / HeldBackSlope(BetaOf(x[k]));
  }
  for (Eigen::Index i = 0; i < x.size(); ++i) {
    auto& row = uncertainty.covariance.emplace_back();
    for (Eigen::Index j = 0; j < x.size(); ++j) row.push_back(unit[i] * covariance(i, j) * unit[j]);
  }
  return uncertainty;
}

Eigen::MatrixXd PrincipalMoves(const UncertainCell& around, double least_variance) {
  const Eigen::VectorXd& variances = around.variances();  // rising
  Eigen::Index count = 0;
  while (count < variances.size() && variances[variances.size() - 1 - count] >= least_variance)
    ++count;
  return around.factor().rightCols(count).rowwise().reverse();
}

Cell::Uncertainty UncertaintyAmong(const Cell& cell,
                                   const std::function<bool(const std::string&)>& taken) {
  const Cell::Uncertainty& all = *cell.uncertainty;
  Cell::Uncertainty some{.parameters = {},
                         .covariance = {},
                         .degrees_of_freedom = all.degrees_of_freedom,
                         .soc_follows_alpha = all.soc_follows_alpha};
  std::vector<std::size_t> kept;
  for (std::size_t k = 0; k < all.parameters.size(); ++k) {
    if (taken(all.parameters[k])) kept.push_back(k);
  }
  for (const std::size_t i : kept) {
    some.parameters.push_back(all.parameters[i]);
    auto& row = some.covariance.emplace_back();
    for (const std::size_t j : kept) row.push_back(all.covariance[i][j]);
  }
  return some;
}

double LeastEigenvalue(const std::vector<std::vector<double>>& covariance) {
  if (covariance.empty()) return 0.0;
  return Eigensystem(AsMatrix(covariance)).eigen.values[0];
}

}  // namespace lipoid
