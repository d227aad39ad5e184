#include "model/battery/uncertain_cell.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <utility>

#include "model/battery/cell_parameters.h"
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
}

void UncertainCell::FindRange() {
  const Eigen::Index n = estimate_.size();
  for (Eigen::Index k = 0; k < n; ++k) {
    if (Kind(k) == nullptr || Kind(k)->any_sign) continue;
    range_.push_back({.more = k,
                      .least = Name(k) == "beta" ? HeldBack(Kind(k)->upper)
                               : Kind(k)->zero   ? 0.0
                                                 : kLeastPositive * estimate_[k]});
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
  const auto bounds = static_cast<Eigen::Index>(range_.size());
  carried_.setZero(n, bounds);
  variance_.setZero(bounds);
  for (Eigen::Index c = 0; c < bounds; ++c) {
    const Bound& bound = range_[static_cast<std::size_t>(c)];
    double apart = 0.0;
    if (bound.more >= 0) {
      carried_.col(c) += covariance_.col(bound.more);
      apart += covariance_(bound.more, bound.more);
    }
    if (bound.less >= 0) {
      carried_.col(c) -= covariance_.col(bound.less);
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
  constexpr double kClose = 1e-6;  // of a standard error
  constexpr int kMostSweeps = 10000;
  Eigen::VectorXd lambda = Eigen::VectorXd::Zero(variance_.size());
  const Eigen::VectorXd error = variance_.cwiseSqrt();
  bool moved = false;
  for (int sweep = 0; sweep < kMostSweeps; ++sweep) {
    double farthest = 0.0;
    for (Eigen::Index c = 0; c < lambda.size(); ++c) {
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
  if (soc_follows_alpha_) KeepCharge(cell);
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

// Curves over charge, over the axis of the drawn alpha: 1 - A' = (1 - A) alpha/alpha'.
void UncertainCell::KeepCharge(Cell& cell) const {
  const double ratio = base_.alpha_C() / cell.alpha_C();
  if (ratio == 1.0) return;
  const auto move = [ratio](double soc) { return 1.0 - (1.0 - soc) * ratio; };
  const auto move_all = [&](std::vector<double> soc) {
    for (double& a : soc) a = move(a);
    return soc;
  };
  const auto move_table = [&](Resistance<double>& r) { r.soc = move_all(std::move(r.soc)); };
  move_table(cell.series_resistance_Ohm);
  for (auto& branch : cell.branches) move_table(branch.resistance_Ohm);
  if (cell.charge_transfer) move_table(cell.charge_transfer->resistance_Ohm);
  if (cell.temperature && cell.temperature->entropy)
    cell.temperature->entropy->soc = move_all(std::move(cell.temperature->entropy->soc));
  if (cell.hysteresis) {
    cell.hysteresis->soc = move_all(std::move(cell.hysteresis->soc));
    cell.hysteresis->folds /= ratio;  // of e-folds over a charge that is another
  }
  const OpenCircuitVoltage curve = cell.open_circuit_voltage;
  const double lo = move(curve.soc_lo());
  const double hi = move(curve.soc_hi());
  switch (curve.method()) {
    case OcvMethod::kLinear:
      cell.open_circuit_voltage =
          OpenCircuitVoltage::Linear(move_all(curve.soc()), curve.voltage_V());
      break;
    case OcvMethod::kMonotoneCubic:
      cell.open_circuit_voltage =
          OpenCircuitVoltage::MonotoneCubic(move_all(curve.soc()), curve.voltage_V());
      break;
    case OcvMethod::kPolynomial:
      cell.open_circuit_voltage = OpenCircuitVoltage::Polynomial(lo, hi, curve.coefficients_V());
      break;
    case OcvMethod::kFourier: {
      // A = 1 - 1/ratio + A'/ratio: another frequency, and harmonics that begin elsewhere.
      const double frequency_rad = curve.frequency_rad() / ratio;
      auto cosine_V = curve.coefficients_V();
      auto sine_V = curve.sine_V();
      for (std::size_t k = 1; k < cosine_V.size(); ++k) {
        const double phase = static_cast<double>(k) * curve.frequency_rad() * (1.0 - 1.0 / ratio);
        const double a = cosine_V[k];
        const double b = sine_V[k - 1];
        cosine_V[k] = a * std::cos(phase) + b * std::sin(phase);
        sine_V[k - 1] = b * std::cos(phase) - a * std::sin(phase);
      }
      cell.open_circuit_voltage = OpenCircuitVoltage::Fourier(
          lo, hi, frequency_rad, std::move(cosine_V), std::move(sine_V));
      break;
    }
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
