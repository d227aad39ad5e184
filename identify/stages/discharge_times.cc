#include "identify/stages/discharge_times.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "identify/optimizers/levenberg_marquardt.h"
#include "model/battery/discharge_time.h"
#include "model/core/errors.h"
#include "model/core/special_values.h"
#include "model/statistics/factorizations.h"
#include "model/statistics/quantiles.h"

namespace lipoid {
namespace {

// What both forms report: the optimum and how sharp it is.
struct Estimate {
  double alpha_C = kNaN;
  double lag_s = kNaN;                // pi²/(3 beta²), at least that of beta = 1
  double unconstrained_lag_s = kNaN;  // may be negative
  double alpha_standard_error_C = kNaN;
  double lag_standard_error_s = kNaN;
};

// 1 or 1/L, times the root of the weight of its square.
double TimeWeight(const DischargeTime& discharge, TimeWeighting weighting) {
  return std::sqrt(discharge.weight) *
         (weighting == TimeWeighting::kRelative ? 1.0 / discharge.time_s : 1.0);
}

// Weighted design of the linear form: L = alpha (A_0/I) - c.
Estimate FitSteady(const std::vector<DischargeTime>& discharges,
                   TimeWeighting weighting,
                   std::optional<double> given_alpha_C) {
  const auto count = static_cast<Eigen::Index>(discharges.size());
  Eigen::MatrixXd design(count, 2);
  Eigen::VectorXd times(count);
  for (Eigen::Index k = 0; k < count; ++k) {
    const auto& d = discharges[static_cast<std::size_t>(k)];
    const double w = TimeWeight(d, weighting);
    design.row(k) << w / d.of_full_A(), -w;
    times[k] = w * d.time_s;
  }
  const double least_lag = SteadyLag(kLargestBeta);
  Estimate estimate;

  if (given_alpha_C) {
    estimate.alpha_C = *given_alpha_C;
    const Eigen::VectorXd rest = times - design.col(0) * *given_alpha_C;
    estimate.unconstrained_lag_s = design.col(1).dot(rest) / design.col(1).squaredNorm();
    estimate.lag_s = std::max(estimate.unconstrained_lag_s, least_lag);
    if (count > 1) {
      const double squares = (rest - design.col(1) * estimate.unconstrained_lag_s).squaredNorm();
      estimate.lag_standard_error_s =
          std::sqrt(squares / static_cast<double>(count - 1) / design.col(1).squaredNorm());
      estimate.alpha_standard_error_C = 0.0;
    }
    return estimate;
  }
  const Eigen::Vector2d solution = LeastSquares(design, times);  // (4.53)
  estimate.alpha_C = solution[0];
  estimate.unconstrained_lag_s = solution[1];
  estimate.lag_s = std::max(solution[1], least_lag);
  if (estimate.lag_s != solution[1]) {
    estimate.alpha_C =
        design.col(0).dot(times - design.col(1) * estimate.lag_s) / design.col(0).squaredNorm();
  }
  if (count > 2) {
    const double variance =
        (times - design * solution).squaredNorm() / static_cast<double>(count - 2);
    const Eigen::Matrix2d information = design.transpose() * design;
    const Eigen::Matrix2d covariance = variance * information.inverse();
    estimate.alpha_standard_error_C = std::sqrt(covariance(0, 0));
    estimate.lag_standard_error_s = std::sqrt(covariance(1, 1));
  }
  return estimate;
}

// 1 + 2 sum_k e^{-k² z}, by (4.31) where z is small.
double Theta(double z) {
  if (z <= 0.0) return kInfinity;
  const bool small = z < 1.0;
  const double q = small ? std::numbers::pi * std::numbers::pi / z : z;
  double sum = 1.0;
  for (int k = 1; k < 8; ++k) sum += 2.0 * std::exp(-k * k * q);
  return small ? std::sqrt(std::numbers::pi / z) * sum : sum;
}

// A time and its slopes.
struct Time {
  double time_s, per_lag, per_alpha_s_per_C;
};

// d L/d alpha and d L/d lag follow from F(L, alpha, beta) = L + U(L; beta) - alpha/I = 0, (4.37),
// with dU/dL = theta(beta² L) - 1 = 2 sum e^{-beta² k² L} and U = lag u(beta² L), beta² = pi²/(3
// lag).
Time ExactTime(double alpha_C, double lag_s, double current_A) {
  const double beta = BetaOfSteadyLag(lag_s);
  const double time_s = ExactDischargeTime(alpha_C, beta, current_A);
  const double z = beta * beta * time_s;
  const double theta = Theta(z);
  // U = lag u(z), z = pi² L/(3 lag): dU/dlag at fixed L = U/lag - z u'(z), u' = 3/pi² (theta - 1).
  const double per_lag = UnavailableLag(beta, time_s) / lag_s -
                         z * 3.0 / (std::numbers::pi * std::numbers::pi) * (theta - 1.0);
  return {time_s, -per_lag / theta, 1.0 / (current_A * theta)};
}

// The squared errors of the times over the logarithms of the lag c = pi²/(3 beta²) and, where it is
// not given, of alpha, so that both stay positive.
class ExactTimesProblem : public LeastSquaresProblem {
 public:
  ExactTimesProblem(const std::vector<DischargeTime>& discharges,
                    TimeWeighting weighting,
                    std::optional<double> given_alpha_C)
      : discharges_(discharges), weighting_(weighting), given_alpha_C_(given_alpha_C) {}

  [[nodiscard]] int size() const override { return given_alpha_C_ ? 1 : 2; }
  [[nodiscard]] Eigen::VectorXd lower() const override {
    Eigen::VectorXd bound = -upper();
    bound[0] = std::log(SteadyLag(kLargestBeta));
    return bound;
  }
  [[nodiscard]] Eigen::VectorXd upper() const override {
    constexpr double kFurthest = 700.0;  // of a logarithm: exp() stays finite
    return Eigen::VectorXd::Constant(size(), kFurthest);
  }

  [[nodiscard]] Eigen::MatrixXd Factor(const Eigen::VectorXd& x, bool) const override {
    const double lag_s = Lag(x);
    const double alpha_C = Alpha(x);
    const auto count = static_cast<Eigen::Index>(discharges_.size());
    Eigen::MatrixXd rows =
        Eigen::MatrixXd::Zero(std::max<Eigen::Index>(count, size() + 1), size() + 1);
    for (Eigen::Index k = 0; k < count; ++k) {
      const auto& d = discharges_[static_cast<std::size_t>(k)];
      const double w = TimeWeight(d, weighting_);
      const Time time = ExactTime(alpha_C, lag_s, d.of_full_A());
      rows(k, 0) = -w * time.per_lag * lag_s;                                   // -dL/dlog(lag)
      if (!given_alpha_C_) rows(k, 1) = -w * time.per_alpha_s_per_C * alpha_C;  // -dL/dlog(alpha)
      rows(k, size()) = w * (d.time_s - time.time_s);
    }
    return TriangularFactor(rows);
  }

  [[nodiscard]] Eigen::VectorXd Point(double alpha_C, double lag_s) const {
    Eigen::VectorXd x(size());
    x[0] = std::log(lag_s);
    if (!given_alpha_C_) x[1] = std::log(alpha_C);
    return x;
  }
  [[nodiscard]] double Alpha(const Eigen::VectorXd& x) const {
    return given_alpha_C_ ? *given_alpha_C_ : std::exp(x[1]);
  }
  [[nodiscard]] static double Lag(const Eigen::VectorXd& x) { return std::exp(x[0]); }

 private:
  const std::vector<DischargeTime>& discharges_;
  TimeWeighting weighting_;
  std::optional<double> given_alpha_C_;
};

Estimate FitExact(const std::vector<DischargeTime>& discharges,
                  TimeWeighting weighting,
                  std::optional<double> given_alpha_C,
                  const Estimate& steady) {
  const ExactTimesProblem problem(discharges, weighting, given_alpha_C);
  const auto fit = MinimizeLevenbergMarquardt(
      problem, problem.Point(std::max(steady.alpha_C, 1e-300), steady.lag_s));
  Estimate estimate;
  estimate.alpha_C = problem.Alpha(fit.x);
  estimate.lag_s = problem.Lag(fit.x);
  // At the bound the unconstrained optimum is on its other side; the steady form says where.
  estimate.unconstrained_lag_s = fit.x[0] > problem.lower()[0] + 1e-9
                                     ? estimate.lag_s
                                     : std::min(steady.unconstrained_lag_s, estimate.lag_s);
  const auto freedom = static_cast<double>(discharges.size()) - problem.size();
  if (freedom > 0) {
    const Eigen::MatrixXd factor = problem.Factor(fit.x, true);
    const Eigen::MatrixXd r = factor.topLeftCorner(problem.size(), problem.size());
    const Eigen::MatrixXd inverse = r.triangularView<Eigen::Upper>().solve(
        Eigen::MatrixXd::Identity(problem.size(), problem.size()));
    const Eigen::MatrixXd covariance = 2.0 * fit.cost / freedom * (inverse * inverse.transpose());
    estimate.lag_standard_error_s = estimate.lag_s * std::sqrt(covariance(0, 0));
    estimate.alpha_standard_error_C =
        given_alpha_C ? 0.0 : estimate.alpha_C * std::sqrt(covariance(1, 1));
  }
  return estimate;
}

// What a second of lag adds to alpha.
double AlphaPerLag(const std::vector<DischargeTime>& discharges, TimeWeighting weighting) {
  double with_lag = 0.0, squares = 0.0;
  for (const DischargeTime& d : discharges) {
    const double w = TimeWeight(d, weighting);
    with_lag += w * w / d.of_full_A();
    squares += w * w / (d.of_full_A() * d.of_full_A());
  }
  return with_lag / squares;
}

double PredictedTime(DischargeForm form, double alpha_C, double beta_per_sqrt_s, double current_A) {
  return form == DischargeForm::kExact && std::isfinite(beta_per_sqrt_s)
             ? ExactDischargeTime(alpha_C, beta_per_sqrt_s, current_A)
             : SteadyDischargeTime(alpha_C, beta_per_sqrt_s, current_A);
}

// alpha at a beta that is known.
Estimate FitAlphaAt(double beta_per_sqrt_s,
                    const std::vector<DischargeTime>& discharges,
                    const DischargeTimesOptions& options) {
  Estimate estimate;
  estimate.lag_s = estimate.unconstrained_lag_s = SteadyLag(beta_per_sqrt_s);
  estimate.lag_standard_error_s = 0.0;
  estimate.alpha_C = 0.0;
  double squares = 0.0, of_slope = 0.0;
  // The steady form is linear in alpha, and the exact one nearly so.
  constexpr int kSteps = 6;
  for (int step = 0; step < kSteps; ++step) {
    double with_error = 0.0;
    squares = of_slope = 0.0;
    for (const DischargeTime& d : discharges) {
      const double w = TimeWeight(d, options.weighting);
      const bool exact =
          step > 0 && options.form == DischargeForm::kExact && std::isfinite(beta_per_sqrt_s);
      const Time at =
          exact
              ? ExactTime(estimate.alpha_C, estimate.lag_s, d.of_full_A())
              : Time{estimate.alpha_C / d.of_full_A() - estimate.lag_s, -1.0, 1.0 / d.of_full_A()};
      const double error = w * (d.time_s - at.time_s);
      const double slope = w * at.per_alpha_s_per_C;
      with_error += slope * error;
      of_slope += slope * slope;
      squares += error * error;
    }
    estimate.alpha_C += with_error / of_slope;
  }
  if (discharges.size() > 1)
    estimate.alpha_standard_error_C =
        std::sqrt(squares / static_cast<double>(discharges.size() - 1) / of_slope);
  return estimate;
}

// Mean charge of the discharges, as from full, at each different current, by rising current.
std::vector<std::pair<double, double>> ChargeByCurrent(
    const std::vector<DischargeTime>& discharges) {
  auto sorted = discharges;
  std::sort(sorted.begin(), sorted.end(), [](const auto& a, const auto& b) {
    return a.of_full_A() != b.of_full_A() ? a.of_full_A() < b.of_full_A() : a.time_s < b.time_s;
  });
  std::vector<std::pair<double, double>> groups;
  double members = 0.0;
  for (const auto& d : sorted) {
    const double charge = d.of_full_A() * d.time_s;
    if (!groups.empty() && d.of_full_A() <= groups.back().first * (1.0 + kCurrentTolerance)) {
      members += d.weight;
      groups.back().second += (charge - groups.back().second) * d.weight / members;
    } else {
      groups.emplace_back(d.of_full_A(), charge);
      members = d.weight;
    }
  }
  return groups;
}

}  // namespace

int CountDifferentCurrents(const std::vector<DischargeTime>& discharges) {
  return static_cast<int>(ChargeByCurrent(discharges).size());
}

DischargeTimesResult FitDischargeTimes(const std::vector<DischargeTime>& discharges,
                                       const DischargeTimesOptions& options,
                                       std::optional<double> given_alpha_C,
                                       std::optional<double> given_beta_per_sqrt_s) {
  for (const auto& d : discharges) {
    Require(d.current_A > 0.0 && d.time_s > 0.0 && d.initial_soc > 0.0 && d.weight > 0.0,
            "current, time, state of charge and weight above 0",
            {{"current_A", d.current_A}, {"time_s", d.time_s}});
  }
  const auto groups = ChargeByCurrent(discharges);
  Require(groups.size() >= (given_alpha_C ? 1U : 2U),
          "at least two different currents, or one and alpha",
          {{"currents", static_cast<double>(groups.size())}});

  Estimate estimate;
  if (given_beta_per_sqrt_s) {
    estimate = FitAlphaAt(*given_beta_per_sqrt_s, discharges, options);
    if (given_alpha_C) {
      estimate.alpha_C = *given_alpha_C;
      estimate.alpha_standard_error_C = 0.0;
    }
  } else {
    estimate = FitSteady(discharges, options.weighting, given_alpha_C);
    if (options.form == DischargeForm::kExact)
      estimate = FitExact(discharges, options.weighting, given_alpha_C, estimate);
    // At the bound of beta any lag from there to none may be the true one, and alpha follows it.
    const double least_lag = SteadyLag(kLargestBeta);
    if (!given_alpha_C && estimate.unconstrained_lag_s < least_lag) {
      const double of_lag_C =
          AlphaPerLag(discharges, options.weighting) * least_lag / std::sqrt(3.0);
      estimate.alpha_standard_error_C = std::hypot(estimate.alpha_standard_error_C, of_lag_C);
    }
  }

  DischargeTimesResult result;
  const int unknowns = (given_alpha_C ? 0 : 1) + (given_beta_per_sqrt_s ? 0 : 1);
  result.degrees_of_freedom = static_cast<int>(discharges.size()) - unknowns;
  result.alpha_C = estimate.alpha_C;
  result.beta_per_sqrt_s =
      given_beta_per_sqrt_s.value_or(std::min(BetaOfSteadyLag(estimate.lag_s), kLargestBeta));
  result.alpha_standard_error_C = estimate.alpha_standard_error_C;
  // beta = pi/sqrt(3 c), so |d beta/d c| = beta/(2 c).
  result.beta_standard_error_per_sqrt_s =
      given_beta_per_sqrt_s
          ? 0.0
          : estimate.lag_standard_error_s * result.beta_per_sqrt_s / (2.0 * estimate.lag_s);

  const bool charge_falls = groups.size() < 2 ? estimate.unconstrained_lag_s > 0.0
                                              : groups.back().second < groups.front().second &&
                                                    estimate.unconstrained_lag_s > 0.0;
  if (given_beta_per_sqrt_s) {
    result.reason =
        std::isfinite(*given_beta_per_sqrt_s) ? "beta was given" : "there is no diffusion";
  } else if (!charge_falls) {
    result.reason = fmt::format(
        "the delivered charge does not fall with the current ({:.4g} C at {:.4g} A, {:.4g} C at "
        "{:.4g} A)",
        groups.front().second,
        groups.front().first,
        groups.back().second,
        groups.back().first);
  } else if (estimate.lag_standard_error_s >= estimate.unconstrained_lag_s) {
    result.reason = fmt::format("pi²/(3 beta²) is {:.3g} s with a standard error of {:.3g} s",
                                estimate.unconstrained_lag_s,
                                estimate.lag_standard_error_s);
  }
  result.identifiable = result.reason.empty();

  // One-sided 95 % bound: the lag is at most its estimate plus t standard errors.
  const double freedom = result.degrees_of_freedom;
  if (!given_beta_per_sqrt_s && freedom > 0 && std::isfinite(estimate.lag_standard_error_s)) {
    const double t = StudentQuantile(freedom, 0.95);
    const double largest_lag =
        std::max(estimate.unconstrained_lag_s, 0.0) + t * estimate.lag_standard_error_s;
    result.beta_lower_bound_per_sqrt_s = std::min(BetaOfSteadyLag(largest_lag), kLargestBeta);
  }
  result.beta_start_per_sqrt_s =
      result.identifiable || given_beta_per_sqrt_s
          ? std::min(result.beta_per_sqrt_s, kLargestBeta)
          : std::clamp(kTypicalBeta, result.beta_lower_bound_per_sqrt_s, kLargestBeta);

  ErrorAccumulator errors;
  for (const auto& d : discharges) {
    const double predicted_s =
        PredictedTime(options.form, result.alpha_C, result.beta_per_sqrt_s, d.of_full_A());
    errors.Add(d.time_s, predicted_s);
    result.rows.push_back({d.file,
                           d.current_A,
                           d.time_s,
                           predicted_s,
                           100.0 * std::abs(d.time_s - predicted_s) / d.time_s});  // (4.56)
  }
  result.errors = errors.Result();
  return result;
}

}  // namespace lipoid
