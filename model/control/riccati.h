#pragma once

/// @file
/// The linear-quadratic regulator of x' = A x + B u: u = -K x with the least integral of
/// x'Qx + u'Ru, K = R^-1 B'P, where P solves the continuous algebraic Riccati equation
///
///   A'P + P A - P B R^-1 B'P + Q = 0
///
/// and is found from the stable invariant subspace of the Hamiltonian matrix. And the regulator of
/// one axis of a vehicle, with integral action. Tests: tests/model/control/riccati_test.cc.

#include <Eigen/Core>
#include <optional>

#include "model/control/error_controller.h"

namespace lipoid {

/// P; none where no solution makes the loop stable, as where (A, B) cannot be stabilised. R > 0.
[[nodiscard]] std::optional<Eigen::MatrixXd> SolveRiccati(const Eigen::MatrixXd& a,
                                                          const Eigen::MatrixXd& b,
                                                          const Eigen::MatrixXd& q,
                                                          const Eigen::MatrixXd& r);

/// Square roots of the weights on an axis' error, its integral and its rate, over that of the
/// pseudo-control: the integral of (w_e e)² + (w_I e_I)² + (w_d e')² + nu² shall be least.
struct RegulatorWeights {
  double error_per_s2;     ///< w_e >= 0
  double integral_per_s3;  ///< w_I > 0
  double rate_per_s;       ///< w_d >= 0
};

/// Gains of (3.60) that are the regulator of e'' = -nu with integral action; their slopes in the
/// weights follow from the equations that the Riccati equation comes to for this chain,
///
///   K_eI = w_I,   K_e² - 2 K_edot K_eI = w_e²,   K_edot² - 2 K_e = w_d²
/// The slopes are those in w_e² and w_d², which do not vanish where a weight does.
struct RegulatorGains {
  ErrorGains gains;
  ErrorGains per_error;     ///< in w_e²
  ErrorGains per_integral;  ///< in w_I
  ErrorGains per_rate;      ///< in w_d²
};
[[nodiscard]] RegulatorGains AxisRegulator(const RegulatorWeights& weights);

}  // namespace lipoid
