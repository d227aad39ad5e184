#pragma once

/// @file
/// Cells that an identification could as well have meant: drawn from the uncertainty that a cell
/// carries (Cell::Uncertainty), for the interval of a prediction.
///
///   x = x^ + sqrt(nu/chi²_nu) F z,   F F' = covariance,   z normal
///
/// is Student's distribution with nu degrees of freedom, so that the parameters of the drawn cells
/// have the intervals that identification reports. Voltages are linear in resistances and in v_oc,
/// so those are drawn as they are, and so are time constants. beta is drawn in its logarithm,
/// because the charge that diffusion holds back goes with 1/beta².
///
/// A draw out of range goes to the cell in range that is nearest to it in the metric of the
/// covariance, as the estimator itself stops at its bounds: a resistance that may not become
/// negative takes its partners along, and their well-known sum stays. In range are resistances and
/// rho_h and M of at least 0, beta of at most 1 and of at least a thousandth of the estimate, alpha, c_j,
/// tau_j, tau_h, i_0, gamma, C_th and R_th of at least a hundredth of the estimate, and v_oc that does not fall with
/// A, except where the estimate falls.
///
/// Cell k depends on the seed and on k alone: not on the number of cells, not on threads. Tests:
/// tests/model/battery/cell_ensemble_test.cc.

#include <cstdint>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

struct CellEnsemble {
  std::vector<Cell> cells;  ///< without the run record and the uncertainty of the one drawn from
  int moved = 0;            ///< of them were drawn out of range
};

/// PreconditionError where the cell has no uncertainty. Names and matrix are as a cell file has
/// them.
[[nodiscard]] CellEnsemble DrawCells(const Cell& cell, int count, std::uint64_t seed);

/// A matrix whose eigenvalues, each coordinate in the unit in which its variance is 1, are negative
/// by no more than this has no negative ones but for rounding. Entries may differ by as much from
/// their mirror images.
inline constexpr double kCovarianceRounding = 1e-8;

/// The least eigenvalue in those units; 0 of an empty matrix. The matrix is square.
[[nodiscard]] double LeastEigenvalue(const std::vector<std::vector<double>>& covariance);

}  // namespace lipoid
