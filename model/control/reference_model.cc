#include "model/control/reference_model.h"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "model/core/errors.h"

namespace lipoid {
namespace {

// Share of the limit with which a long way is braked; the rest is for the lag of the braking.
constexpr double kBrake = 0.7;

}  // namespace

ReferenceModel::ReferenceModel(double omega_rad_per_s, double damping, double step_s, double limit)
    : step_s_(step_s),
      limit_(limit),
      far_(8.0 * damping * damping * kBrake * limit / (omega_rad_per_s * omega_rad_per_s)) {
  Require(omega_rad_per_s > 0.0, "a positive frequency", {{"omega_rad_per_s", omega_rad_per_s}});
  Require(damping > 0.0, "a positive damping", {{"damping", damping}});
  Require(step_s > 0.0, "a positive step", {{"step_s", step_s}});
  Require(limit > 0.0, "a positive limit", {{"limit", limit}});
  const double w = omega_rad_per_s;
  Eigen::Matrix2d generator;
  generator << 0.0, w, -w, -2.0 * damping * w;  // (3.59) of the gap and of the rate over w
  const Eigen::Matrix2d flow = (generator * step_s).exp();
  // With a = -(k gap + d rate) held over a step, gap += step (rate + step a/2) and rate += step a
  // have the characteristic polynomial z² - (2 - k step²/2 - d step) z + 1 + k step²/2 - d step: it
  // shall be that of the flow, z² - trace z + det. For short steps 1 - trace + det = (1 - p)(1 - q)
  // of the poles p and q is small: as the determinant of flow - 1 it keeps its digits.
  const Eigen::Matrix2d change = flow - Eigen::Matrix2d::Identity();
  const double both = change.determinant();
  per_gap_ = both / (step_s * step_s);
  per_rate_ = (-change.trace() - 0.5 * both) / step_s;
}

LoopReference<double> ReferenceModel::Step(double command) {
  const double gap = value_ - command;
  // (3.59) settles at the rate omega_0/(2 zeta_0) times the gap. Where sqrt(2 kBrake limit |gap|),
  // from which braking still ends at the command, is less, the gap counts only as far as that.
  const double felt =
      std::abs(gap) <= far_ ? gap : std::copysign(std::sqrt(far_ * std::abs(gap)), gap);
  const double wanted = -(per_gap_ * felt + per_rate_ * rate_);
  const LoopReference<double> now{value_, rate_, std::clamp(wanted, -limit_, limit_)};
  value_ += step_s_ * (rate_ + 0.5 * step_s_ * now.acceleration);
  rate_ += step_s_ * now.acceleration;
  return now;
}

}  // namespace lipoid
