#pragma once

/// @file
/// A fit at its solution as its trust sees it: every unknown takes part, the nodes of v_oc(A) and of
/// the tables too, so that what is uncertain in the curve makes resistances uncertain, as it should.
/// Tables are asked at three states of charge, r_s(0.2), r_s(0.5), r_s(0.8). What stands at a bound
/// is held. docs/verdicts.md. Tests: tests/identify/joint/joint_trust_test.cc,
/// tests/identify/stages/staged_trust_test.cc.

#include <string>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// Parameters are the rates that were searched, then the linear unknowns of JointLayout with rises
/// of v_oc for its nodes.
struct LinearizedFit {
  std::vector<std::string> rates;
  std::vector<int> slots;  ///< of the rates, in RateSlots
  std::vector<FittedRows> logs;
  Eigen::MatrixXd penalty;
  std::vector<Eigen::Index> held;
  /// beta, r_s, r_j, tau_j, c_j, r_ct, i_0, rho_h, tau_h, but for what was given.
  std::vector<TrustedQuantity> quantities;

  /// Sensitivities to these parameters, from those to all nonlinear and linear ones (Observations).
  [[nodiscard]] Eigen::MatrixXd Project(Eigen::MatrixXd sensitivity,
                                        const JointSolution& solution) const;
  /// A quantity that is a combination of linear unknowns.
  [[nodiscard]] TrustedQuantity Quantity(std::string name, std::string unit, double value) const;
  [[nodiscard]] Eigen::Index Linear(int unknown) const {
    return static_cast<Eigen::Index>(rates.size()) + unknown;
  }
};

/// Tables are asked at states of charge of the cell.
[[nodiscard]] LinearizedFit Linearize(const Observations& seen,
                                      const JointSolution& solution,
                                      const GivenParameters& known,
                                      const FitAxis& axis = {});

/// The steps of the parameters that minimize the quadratic with this matrix, one for each right side. Those that are
/// held stay, and so does what carries nothing.
[[nodiscard]] Eigen::MatrixXd StepsOf(Eigen::MatrixXd square,
                                      Eigen::MatrixXd right,
                                      const std::vector<Eigen::Index>& held);

}  // namespace lipoid
