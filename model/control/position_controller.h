#pragma once

/// @file
/// Position to tilt: the commanded roll and pitch of (3.67)-(3.68), with signs as z down wants them
/// (docs/corrections.md): Y'' = +g Phi, X'' = -g Theta. Errors and velocities are both turned into
/// the heading. Tests: tests/model/control/position_controller_test.cc.

#include <algorithm>
#include <cmath>

#include "model/vehicle/rigid_body.h"

namespace lipoid {

struct PositionGains {
  double proportional_rad_per_m = 0.0;  ///< K_pX = K_pY
  double derivative_rad_s_per_m = 0.0;  ///< K_dX = K_dY
  double tilt_limit_rad = 0.35;         ///< of each commanded angle
};

struct TiltCommand {
  double roll_rad;
  double pitch_rad;
};

inline TiltCommand PositionControl(const PositionGains& gains,
                                   double yaw_rad,
                                   double error_x_m,  ///< X - X_R
                                   double error_y_m,
                                   double velocity_x_m_per_s,  ///< inertial, less the reference's
                                   double velocity_y_m_per_s) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  const double limit = gains.tilt_limit_rad;
  const double ahead =
      gains.proportional_rad_per_m * (c * error_x_m + s * error_y_m) +
      gains.derivative_rad_s_per_m * (c * velocity_x_m_per_s + s * velocity_y_m_per_s);
  const double right =
      gains.proportional_rad_per_m * (c * error_y_m - s * error_x_m) +
      gains.derivative_rad_s_per_m * (c * velocity_y_m_per_s - s * velocity_x_m_per_s);
  return {std::clamp(-right, -limit, limit),  // (3.67)
          std::clamp(ahead, -limit, limit)};  // (3.68)
}

}  // namespace lipoid
