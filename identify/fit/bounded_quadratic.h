#pragma once

/// @file
/// A small strictly convex quadratic within bounds, solved exactly:
///
///   minimize 1/2 x'G x - g'x  with  lower <= x <= upper
///
/// by block principal pivoting (Portugal, Judice and Vicente 1994; Kim and Park 2011): guess which
/// bounds are active, solve the rest by Cholesky, exchange all that disagree with the optimality
/// conditions at once; where that does not bring fewer disagreements, one at a time by Murty's
/// rule, which ends after finitely many, though they may be very many: then by an active set from
/// within the bounds, which never rises. A good guess, say the answer to a neighbouring problem,
/// ends after one factorization. No library at hand has this: general solvers for quadratic
/// programs need ten times as long for a hundred unknowns as the sums that make G.
/// Tests: tests/identify/fit/bounded_quadratic_test.cc.

#include <Eigen/Core>
#include <vector>

namespace lipoid {

struct BoundedQuadraticResult {
  Eigen::VectorXd x;
  std::vector<char> active;  ///< 1 where x stands at its lower bound, 2 at the upper
  int factorizations = 0;
  bool solved = false;  ///< false: G is not positive definite, or the exchanges did not end
};

/// G symmetric (its lower triangle is read) and positive definite; bounds may be infinite, and there
/// are no upper ones where `upper` is empty. Where lower and upper are the same x[k] is held.
/// `guess` says which bounds may be active; empty: none.
[[nodiscard]] BoundedQuadraticResult MinimizeBoundedQuadratic(const Eigen::MatrixXd& G,
                                                              const Eigen::VectorXd& g,
                                                              const Eigen::VectorXd& lower,
                                                              const std::vector<char>& guess = {},
                                                              const Eigen::VectorXd& upper = {});

}  // namespace lipoid
