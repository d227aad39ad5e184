#pragma once

/// @file
/// Closed-loop poles of the altitude and the attitude loop against the voltage ratio xi, three
/// ways:
///
///   closed form     s³ + kappa (K_edot s² + K_e s + K_eI), with kappa(xi) of docs/corrections.md
///   quasi-static    the derivative of the flight itself, motors at their equilibrium (5.10)
///   full            the same with the motors' lag
///
/// All are continuous, unclipped and unquantised, on an ideal source, at the hover of that xi (with
/// the integral that holds it: e_I = 0 is no equilibrium for xi < 1). The attitude is pitch; roll
/// has the same poles. Derivatives are exact, by automatic differentiation. Tests:
/// tests/model/analysis/poles_test.cc.

#include <Eigen/Core>
#include <complex>
#include <vector>

#include "model/control/gains.h"
#include "model/vehicle/powertrain.h"

namespace lipoid {

enum class Loop { kAltitude, kAttitude };

using Poles = std::vector<std::complex<double>>;  ///< by falling real part, then rising imaginary

/// kappa(xi) = d(T/m)/du at the hover of xi: 1 at xi = 1 without losses of speed controllers. xi > 0.
[[nodiscard]] double Kappa(const Vehicle& vehicle, double xi);

/// Roots of s³ + A_3 s² + A_2 s + A_1, the denominator of (5.26), and of (5.48) for small signals.
[[nodiscard]] Poles ClosedFormPoles(const ErrorGains& gains, double kappa);

/// A hover: what supplies the motors, and the voltage that commands reckon with.
struct HoverPoint {
  Supply<double> supply;
  double assumed_V;  ///< v_b0 (3.17), or with compensation the battery's own (5.52)
};
/// On an ideal source of xi v_b0.
[[nodiscard]] HoverPoint HoverAt(const Vehicle& vehicle, double xi);

/// Jacobian of the whole closed loop, of vehicles of more rotors that of the equivalent quadrotor
/// (model/vehicle/allocation.h), at a hover: states of model/vehicle/plant.h, then the
/// integrals of altitude, roll, pitch and yaw error.
inline constexpr int kClosedLoopStates = 21;
using ClosedLoopMatrix = Eigen::Matrix<double, kClosedLoopStates, kClosedLoopStates>;
[[nodiscard]] ClosedLoopMatrix LinearizeClosedLoop(const Vehicle& vehicle,
                                                   const Gains& gains,
                                                   const HoverPoint& hover,
                                                   bool motor_lag);

/// Time derivative of the closed loop at a hover: zero, as far as the trim is one.
[[nodiscard]] Eigen::Matrix<double, kClosedLoopStates, 1> ClosedLoopRateAtHover(
    const Vehicle& vehicle, const Gains& gains, const HoverPoint& hover, bool motor_lag);

/// Small motions of one axis about a hover, as its controller sees them: the acceleration that
/// follows the pseudo-control, y'' = kappa nu/(lag s + 1).
struct AxisResponse {
  double kappa;
  double lag_s;
};
struct HoverResponse {
  AxisResponse altitude;
  AxisResponse roll;
  AxisResponse pitch;
  AxisResponse yaw;
};
[[nodiscard]] HoverResponse ResponseAtHover(const Vehicle& vehicle, const HoverPoint& hover);

/// The part of it that is the loop: integral, value, rate and, with lag, the speed pattern that
/// drives it. 3 or 4 poles.
[[nodiscard]] Poles LoopPoles(Loop loop, const ClosedLoopMatrix& matrix, bool motor_lag);

struct PolesRow {
  double xi;
  double kappa;
  Poles closed_form;
  Poles quasistatic;
  Poles full;
};

[[nodiscard]] PolesRow PolesAt(Loop loop, const Vehicle& vehicle, const Gains& gains, double xi);

}  // namespace lipoid
