#include "model/control/riccati.h"

#include <Eigen/LU>
#include <cmath>

#include "model/core/errors.h"
#include "model/statistics/factorizations.h"

namespace lipoid {

std::optional<Eigen::MatrixXd> SolveRiccati(const Eigen::MatrixXd& a,
                                            const Eigen::MatrixXd& b,
                                            const Eigen::MatrixXd& q,
                                            const Eigen::MatrixXd& r) {
  const Eigen::Index n = a.rows();
  const auto per_r = Inverse(r);
  if (!per_r) return std::nullopt;
  const Eigen::MatrixXd control = b * *per_r * b.transpose();
  Eigen::MatrixXd hamiltonian(2 * n, 2 * n);
  hamiltonian << a, -control, -q, -a.transpose();
  const auto eigen = EigenOf(hamiltonian);
  if (!eigen) return std::nullopt;
  // What the stable eigenvectors span, in real vectors: of a pair, the first gives its real part, the
  // second, its conjugate, the imaginary one.
  Eigen::MatrixXd stable(2 * n, n);
  Eigen::Index found = 0;
  for (Eigen::Index k = 0; k < 2 * n; ++k) {
    if (!(eigen->values[k].real() < 0.0)) continue;
    if (found == n) return std::nullopt;
    if (eigen->values[k].imag() < 0.0) {
      stable.col(found++) = eigen->vectors.col(k).imag();
    } else {
      stable.col(found++) = eigen->vectors.col(k).real();
    }
  }
  if (found < n) return std::nullopt;
  const auto per_top = Inverse(stable.topRows(n));
  if (!per_top) return std::nullopt;
  const Eigen::MatrixXd p = stable.bottomRows(n) * *per_top;
  return 0.5 * (p + p.transpose());
}

RegulatorGains AxisRegulator(const RegulatorWeights& weights) {
  const double error = weights.error_per_s2;
  const double rate = weights.rate_per_s;
  Require(weights.integral_per_s3 > 0.0, "w_I > 0", {{"w_I", weights.integral_per_s3}});
  // States e_I, e, e'; in units of time in which w_I is 1, so that all gains are of order 1.
  const double unit = std::cbrt(weights.integral_per_s3);
  Eigen::Matrix3d a = Eigen::Matrix3d::Zero();
  a(0, 1) = a(1, 2) = 1.0;
  const Eigen::Vector3d b(0.0, 0.0, -1.0);
  Eigen::Matrix3d q = Eigen::Matrix3d::Zero();
  q(0, 0) = 1.0;
  q(1, 1) = std::pow(error / (unit * unit), 2);
  q(2, 2) = std::pow(rate / unit, 2);
  const auto p = SolveRiccati(a, b, q, Eigen::MatrixXd::Identity(1, 1));
  Require(p.has_value(), "weights with a regulator", {{"w_e", error}, {"w_d", rate}});
  const Eigen::RowVector3d k = -b.transpose() * *p;  // nu = -K x with b = -1
  RegulatorGains out;
  out.gains = {.proportional = -k[1] * -unit * unit,
               .integral = -k[0] * -unit * unit * unit,
               .derivative = -k[2] * -unit};
  const ErrorGains& g = out.gains;
  // K_edot² - 2 K_e = w_d², K_e² - 2 K_edot K_eI = w_e², K_eI = w_I, differentiated.
  Eigen::Matrix2d left;  // of dK_e, dK_edot
  left << -2.0, 2.0 * g.derivative, 2.0 * g.proportional, -2.0 * g.integral;
  const auto slopes = [&](double d_rate2, double d_error2, double d_integral) -> ErrorGains {
    const Eigen::Vector2d right(d_rate2, d_error2 + 2.0 * g.derivative * d_integral);
    const Eigen::Vector2d d = left.inverse() * right;
    return {.proportional = d[0], .integral = d_integral, .derivative = d[1]};
  };
  out.per_error = slopes(0.0, 1.0, 0.0);
  out.per_integral = slopes(0.0, 0.0, 1.0);
  out.per_rate = slopes(1.0, 0.0, 0.0);
  return out;
}

}  // namespace lipoid
