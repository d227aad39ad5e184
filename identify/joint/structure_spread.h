#pragma once

/// @file
/// What the choice of structure adds to the uncertainty of a parameter. The data chose among the
/// structures that were tried; had the noise been another one they might have chosen another of
/// those that predict nearly as well (Buckland, Burnham and Augustin 1997):
///
///   added variance = sum_m w_m (q_m - q)² + (q_fine - q)² + (q_half - q)²
///
/// q is the estimate, q_m that of structure m and w_m its weight (joint_choice.h). q_fine - q is the
/// error of tables of straight lines against a smooth truth, estimated by halving them, and q_half - q
/// that of a warming that was assumed, estimated by halving it. Two
/// quantities that differ together have the covariance that products give in place of the squares.
/// Tests: tests/identify/joint/structure_spread_test.cc.

#include <Eigen/Core>
#include <functional>
#include <string>

#include "identify/joint/joint_choice.h"

namespace lipoid {

/// Which branch of another solution stands for one of the solution that was taken.
enum class BranchMatch {
  kNearest,  ///< the nearest time constant, though it stand for others too: what is said of one branch
  kEachOnce  ///< each is one of the nearest there, or of none: resistances keep their sum
};

/// What a solution says of a quantity of the uncertainty report, by its name there: beta, tau_j,
/// r_s, r_j, r_ct and these at a state of charge, r_s(0.5), c_j, r_total(0.5), tau_h, i_0, rho_h.
/// Branches are counted as in the solution that was `taken`; in another one the branch with the
/// nearest time constant stands for it, and with it what that one shares with others that have no
/// nearer one: a branch that was split in two is compared as one. With kEachOnce a branch that has no
/// other stands at 0 Ohm. A constant stands for its value at every state of
/// charge; what a table says of a constant is its mean at 0.2, 0.5 and 0.8. NaN where the solution
/// has no such quantity. States of charge are those of the cell.
[[nodiscard]] double ValueIn(const JointSolution& solution,
                             const std::string& name,
                             double typical_A,
                             const JointSolution& taken,
                             const FitAxis& axis = {},
                             BranchMatch match = BranchMatch::kNearest);

/// v_oc at a state of charge; `reference` is that of the fit. NaN where the curve was given.
[[nodiscard]] double OpenCircuitVoltageIn(const JointSolution& solution,
                                          const OpenCircuitVoltage& reference,
                                          double soc);

/// The roots of these terms with their signs, of the quantity that `value` reads from a solution:
/// the added variance is the sum of their squares. Structures that do not have the quantity (NaN)
/// say nothing of it.
[[nodiscard]] Eigen::VectorXd SpreadOverStructures(
    const JointChoice& choice, const std::function<double(const JointSolution&)>& value);

}  // namespace lipoid
