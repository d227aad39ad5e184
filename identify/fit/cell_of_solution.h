#pragma once

/// @file
/// From the unknowns of a fit to the cell they describe. Tests:
/// tests/identify/joint/joint_run_test.cc (ItsCellIsWhatWasFitted), structure_spread_test.cc.

#include <limits>
#include <utility>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "model/battery/cell.h"

namespace lipoid {

/// The states of charge that rows reached: nodes beyond them, but for the next one, are no part of
/// a cell.
struct ReachedSoc {
  double lowest = -std::numeric_limits<double>::infinity();
  double highest = std::numeric_limits<double>::infinity();

  /// The first and the last of these nodes, at least so many apart.
  [[nodiscard]] std::pair<std::size_t, std::size_t> Of(const std::vector<double>& nodes,
                                                       std::size_t least) const;
};

/// v_oc(A) at its nodes, which the solution has.
[[nodiscard]] OpenCircuitVoltage CurveOf(const JointSolution& solution,
                                         const OpenCircuitVoltage& reference,
                                         const ReachedSoc& reached = {});

/// Puts beta, the resistances, branches and terms of a solution in place of those of the cell.
void PutInto(Cell& cell,
             const JointSolution& solution,
             double typical_A,
             const ReachedSoc& reached = {});

}  // namespace lipoid
