#include "model/vehicle/wind.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "model/core/errors.h"

namespace lipoid {
namespace {

constexpr double kFoot_m = 0.3048;
constexpr double kForgotten = 100.0;               // e^-100: what was before is below rounding
constexpr std::uint32_t kWindStream = 0x77696e64;  // of its own, whatever else the seed feeds

}  // namespace

DrydenParameters DrydenAt(double altitude_m, double wind_at_20ft_m_per_s) {
  const double h = std::clamp(altitude_m / kFoot_m, 10.0, 1000.0);
  const double shape = 0.177 + 0.000823 * h;
  const double vertical = 0.1 * wind_at_20ft_m_per_s;
  return {
      kFoot_m * h / std::pow(shape, 1.2), kFoot_m * h, vertical / std::pow(shape, 0.4), vertical};
}

double DrydenAlong::Step(double theta, NormalNoise& noise) {
  state_ = std::exp(-theta) * state_ + std::sqrt(-std::expm1(-2.0 * theta)) * noise();
  return state_;
}

// White noise through 1/(s + 1) gives y_1, once more y_2, each scaled to unit variance; then
//   dy_1 = -y_1 dtheta + sqrt 2 dW,   dy_2 = (-y_2 + sqrt 2 y_1) dtheta,
// their covariance is sqrt 1/2, and sqrt(3/2) y_1 + (1 - sqrt 3)/2 y_2 has Phi_v.
void DrydenAcross::Start(NormalNoise& noise) {
  state_[0] = noise();
  state_[1] = std::numbers::sqrt2 / 2.0 * (state_[0] + noise());
}

double DrydenAcross::Step(double theta, NormalNoise& noise) {
  if (theta != theta_) Discretize(theta);
  const double first = noise();
  const double second = noise();
  state_[1] = decay_ * state_[1] + couple_ * state_[0] + spread_[1] * first + spread_[2] * second;
  state_[0] = decay_ * state_[0] + spread_[0] * first;
  return std::sqrt(1.5) * state_[0] + 0.5 * (1.0 - std::numbers::sqrt3) * state_[1];
}

// The noise of a step has the covariance P - F P F'. Its entries, with x = 2 theta, are
//   1 - e^-x,   sqrt 1/2 (1 - e^-x (1 + x)),   1 - e^-x (1 + x + x²/2),
// tails of the series of e^x: as sums of positive terms they lose no digits where steps are small.
void DrydenAcross::Discretize(double theta) {
  theta_ = theta;
  decay_ = std::exp(-theta);
  couple_ = std::numbers::sqrt2 * theta * decay_;
  spread_ = {};
  const double x = std::min(kForgotten, 2.0 * theta);
  if (x == 0.0) return;
  double third = 0.0;
  double term = x * x * x / 6.0;
  for (int k = 4; third + term != third; ++k) {
    third += term;
    term *= x / k;
  }
  const double second = third + 0.5 * x * x;
  const double fade = std::exp(-x);
  spread_[0] = std::sqrt(fade * (second + x));
  spread_[1] = std::numbers::sqrt2 / 2.0 * fade * second / spread_[0];
  spread_[2] = std::sqrt(std::max(0.0, fade * third - spread_[1] * spread_[1]));
}

Wind::Wind(const WindOptions& options, std::uint64_t seed, double step_s)
    : mean_m_per_s_{options.wind_x_m_per_s, options.wind_y_m_per_s, options.wind_z_m_per_s},
      wind_at_20ft_m_per_s_(options.gusts_m_per_s),
      step_s_(step_s),
      noise_(seed, kWindStream) {
  Require(step_s > 0.0, "step_s > 0", {{"step_s", step_s}});
  const double speed = std::hypot(mean_m_per_s_[0], mean_m_per_s_[1]);
  if (speed > 0.0) {
    along_x_ = mean_m_per_s_[0] / speed;
    along_y_ = mean_m_per_s_[1] / speed;
  }
  along_.Start(noise_);
  across_.Start(noise_);
  vertical_.Start(noise_);
}

Triple<double> Wind::Step(double altitude_m, double airspeed_m_per_s) {
  if (!(wind_at_20ft_m_per_s_ > 0.0)) return mean_m_per_s_;
  const DrydenParameters at = DrydenAt(altitude_m, wind_at_20ft_m_per_s_);
  const double way_m = step_s_ * std::max(at.horizontal_sigma_m_per_s, airspeed_m_per_s);
  const double theta = way_m / at.horizontal_length_m;
  const double u = at.horizontal_sigma_m_per_s * along_.Step(theta, noise_);
  const double v = at.horizontal_sigma_m_per_s * across_.Step(theta, noise_);
  const double w = at.vertical_sigma_m_per_s * vertical_.Step(way_m / at.vertical_length_m, noise_);
  return {mean_m_per_s_[0] + along_x_ * u - along_y_ * v,
          mean_m_per_s_[1] + along_y_ * u + along_x_ * v,
          mean_m_per_s_[2] + w};
}

}  // namespace lipoid
