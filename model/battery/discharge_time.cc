#include "model/battery/discharge_time.h"

#include <algorithm>
#include <boost/math/constants/constants.hpp>
#include <boost/math/tools/roots.hpp>
#include <cmath>
#include <cstdint>
#include <limits>

#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kPi = boost::math::constants::pi<double>();

}  // namespace

double SteadyLag(double beta_per_sqrt_s) {
  return kPi * kPi / (3.0 * beta_per_sqrt_s * beta_per_sqrt_s);  // (4.40)
}

double BetaOfSteadyLag(double lag_s) {
  return lag_s > 0.0 ? kPi / std::sqrt(3.0 * lag_s) : std::numeric_limits<double>::infinity();
}

double UnavailableLag(double beta_per_sqrt_s, double time_s) {
  Require(beta_per_sqrt_s > 0.0 && time_s >= 0.0,
          "beta > 0 and time >= 0",
          {{"beta_per_sqrt_s", beta_per_sqrt_s}, {"time_s", time_s}});
  const double beta_squared = beta_per_sqrt_s * beta_per_sqrt_s;
  const double x = beta_squared * time_s;
  // By (4.31) the sum is a theta function: for small x its other form needs one term,
  // L + U(L) = 2 sqrt(pi L)/beta; the next is below e^{-pi²/x}, 1e-17 of it at x = 0.25.
  if (x < 0.25) return 2.0 * std::sqrt(kPi * time_s) / beta_per_sqrt_s - time_s;
  double sum = 0.0;  // of e^{-k² x}/k²; the 13th term is below 1e-18 at x = 0.25
  for (int k = 13; k >= 1; --k) sum += std::exp(-k * k * x) / (k * k);
  return 2.0 / beta_squared * (kPi * kPi / 6.0 - sum);  // (4.37)
}

double SteadyDischargeTime(double alpha_C, double beta_per_sqrt_s, double current_A) {
  return std::max(0.0, alpha_C / current_A - SteadyLag(beta_per_sqrt_s));  // (4.53)
}

double ExactDischargeTime(double alpha_C, double beta_per_sqrt_s, double current_A) {
  Require(alpha_C > 0.0 && current_A > 0.0,
          "alpha > 0 and current > 0",
          {{"alpha_C", alpha_C}, {"current_A", current_A}});
  const double target = alpha_C / current_A;
  // L + U(L) rises from 0; U >= 0 puts L below the target, U <= SteadyLag above the difference.
  const auto excess = [&](double time_s) {
    return time_s + UnavailableLag(beta_per_sqrt_s, time_s) - target;
  };
  double low = std::max(0.0, target - SteadyLag(beta_per_sqrt_s));
  double high = target;
  if (excess(low) >= 0.0) return low;
  if (excess(high) <= 0.0) return high;
  std::uintmax_t steps = 200;
  const auto bracket = boost::math::tools::toms748_solve(
      excess, low, high, boost::math::tools::eps_tolerance<double>(), steps);  // (4.37)
  return 0.5 * (bracket.first + bracket.second);
}

}  // namespace lipoid
