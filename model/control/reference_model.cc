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
  generator << 0.0, 1.0, -w * w, -2.0 * damping * w;  // (3.59)
  const Eigen::Matrix2d flow = (generator * step_s).exp();
  flow_ = {flow(0, 0), flow(0, 1), flow(1, 0), flow(1, 1)};
}

ReferenceModel::Output ReferenceModel::Step(double command) {
  const double gap = value_ - command;
  // (3.59) settles at the rate omega_0/(2 zeta_0) times the gap. Where sqrt(2 kBrake limit |gap|),
  // from which braking still ends at the command, is less, the gap counts only as far as that.
  const double felt =
      std::abs(gap) <= far_ ? gap : std::copysign(std::sqrt(far_ * std::abs(gap)), gap);
  const double wanted = (flow_[2] * felt + flow_[3] * rate_ - rate_) / step_s_;
  const Output now{value_, rate_, std::clamp(wanted, -limit_, limit_)};
  if (felt == gap && std::abs(wanted) <= limit_) {
    value_ = command + flow_[0] * gap + flow_[1] * rate_;
  } else {
    value_ += step_s_ * (rate_ + 0.5 * step_s_ * now.acceleration);
  }
  rate_ += step_s_ * now.acceleration;
  return now;
}

}  // namespace lipoid
