#pragma once

/// @file
/// Cells that an identification could as well have meant: drawn from the uncertainty that a cell
/// carries (Cell::Uncertainty), for the interval of a prediction.
///
///   x = x^ + sqrt(nu/chi²_nu) F z,   F F' = covariance,   z normal
///
/// is Student's distribution with nu degrees of freedom, so that the parameters of the drawn cells
/// have the intervals that identification reports. What x is made of, and how a draw out of range is moved:
/// uncertain_cell.h.
///
/// Cell k depends on the seed and on k alone: not on the number of cells, not on threads. Tests:
/// tests/model/battery/cell_ensemble_test.cc.

#include <cstddef>
#include <cstdint>
#include <string>
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

/// What an interval means that is of drawn cells of which so many were moved, one sentence; empty
/// where most of them are as they were drawn.
[[nodiscard]] std::string DoubtAboutMoved(std::size_t moved, std::size_t cells);

}  // namespace lipoid
