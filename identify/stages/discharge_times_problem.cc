#include "identify/stages/discharge_times_problem.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "model/battery/discharge_time.h"
#include "model/statistics/factorizations.h"

namespace lipoid {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kFurthest = 700.0;  // of a logarithm: exp() stays finite

// 1 + 2 sum_k e^{-k² z}, by (4.31) where z is small.
double Theta(double z) {
  if (z <= 0.0) return std::numeric_limits<double>::infinity();
  const bool small = z < 1.0;
  const double q = small ? kPi * kPi / z : z;
  double sum = 1.0;
  for (int k = 1; k < 8; ++k) sum += 2.0 * std::exp(-k * k * q);
  return small ? std::sqrt(kPi / z) * sum : sum;
}

// A time and its slopes.
struct Time {
  double time_s, per_lag, per_alpha_s_per_C;
};

Time SteadyTime(double alpha_C, double lag_s, double current_A) {
  return {alpha_C / current_A - lag_s, -1.0, 1.0 / current_A};  // (4.53)
}

// d L/d alpha and d L/d lag follow from F(L, alpha, beta) = L + U(L; beta) - alpha/I = 0, (4.37),
// with dU/dL = theta(beta² L) - 1 = 2 sum e^{-beta² k² L} and U = lag u(beta² L), beta² = pi²/(3
// lag).
Time ExactTime(double alpha_C, double lag_s, double current_A) {
  const double beta = BetaOfSteadyLag(lag_s);
  const double time_s = ExactDischargeTime(alpha_C, beta, current_A);
  const double z = beta * beta * time_s;
  const double theta = Theta(z);
  // U = lag u(z), z = pi² L/(3 lag): dU/dlag at fixed L = U/lag - z u'(z), u' = 3/pi² (theta - 1).
  const double per_lag =
      UnavailableLag(beta, time_s) / lag_s - z * 3.0 / (kPi * kPi) * (theta - 1.0);
  return {time_s, -per_lag / theta, 1.0 / (current_A * theta)};
}

}  // namespace

double TimeWeight(const DischargeTime& discharge, TimeWeighting weighting) {
  return std::sqrt(discharge.weight) *
         (weighting == TimeWeighting::kRelative ? 1.0 / discharge.time_s : 1.0);
}

DischargeTimesProblem::DischargeTimesProblem(const std::vector<DischargeTime>& discharges,
                                             const DischargeTimesOptions& options,
                                             std::optional<double> given_alpha_C,
                                             double decades)
    : discharges_(discharges),
      options_(options),
      given_alpha_C_(given_alpha_C),
      decades_(std::min(decades * std::log(10.0), kFurthest)) {}

Eigen::VectorXd DischargeTimesProblem::lower() const {
  Eigen::VectorXd bound = Start().array() - decades_;
  bound[0] = std::log(SteadyLag(kLargestBeta));
  return bound;
}

Eigen::VectorXd DischargeTimesProblem::upper() const { return Start().array() + decades_; }

Eigen::VectorXd DischargeTimesProblem::Start() const {
  double most_C = 0.0;
  for (const auto& d : discharges_) most_C = std::max(most_C, d.of_full_A() * d.time_s);
  return Point(most_C, SteadyLag(kTypicalBeta));
}

Eigen::VectorXd DischargeTimesProblem::Point(double alpha_C, double lag_s) const {
  Eigen::VectorXd x(size());
  x[0] = std::log(lag_s);
  if (!given_alpha_C_) x[1] = std::log(alpha_C);
  return x;
}

double DischargeTimesProblem::Alpha(const Eigen::VectorXd& x) const {
  return given_alpha_C_ ? *given_alpha_C_ : std::exp(x[1]);
}

double DischargeTimesProblem::Lag(const Eigen::VectorXd& x) const { return std::exp(x[0]); }

Eigen::MatrixXd DischargeTimesProblem::Factor(const Eigen::VectorXd& x, bool) const {
  const double lag_s = Lag(x);
  const double alpha_C = Alpha(x);
  const auto count = static_cast<Eigen::Index>(discharges_.size());
  Eigen::MatrixXd rows =
      Eigen::MatrixXd::Zero(std::max<Eigen::Index>(count, size() + 1), size() + 1);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& d = discharges_[static_cast<std::size_t>(k)];
    const double w = TimeWeight(d, options_.weighting);
    const Time time = options_.form == DischargeForm::kExact
                          ? ExactTime(alpha_C, lag_s, d.of_full_A())
                          : SteadyTime(alpha_C, lag_s, d.of_full_A());
    rows(k, 0) = -w * time.per_lag * lag_s;                                   // -dL/dlog(lag)
    if (!given_alpha_C_) rows(k, 1) = -w * time.per_alpha_s_per_C * alpha_C;  // -dL/dlog(alpha)
    rows(k, size()) = w * (d.time_s - time.time_s);
  }
  return TriangularFactor(rows);
}

}  // namespace lipoid
