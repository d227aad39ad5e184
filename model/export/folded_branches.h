#pragma once

/// @file
/// Branches that a simulator cannot see, made part of the series resistance. Thesis cells have a
/// branch of 0.24 ms and some microohms: it changes no voltage that a log could show, and makes the
/// explicit solvers of others take steps of 0.1 ms or explode. Tests:
/// tests/model/export/folded_branches_test.cc.

#include <string>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

/// A branch is folded where it is faster than this, whatever its resistance ...
inline constexpr double kFoldedTimeConstant_s = 5e-3;
/// ... or where it has less than this share of r_s and is faster than the next number: a slow
/// branch stays, however small, so that exact targets remain exact.
inline constexpr double kFoldedShare = 1e-3;
inline constexpr double kFoldedSmallTimeConstant_s = 1.0;

struct FoldedCell {
  Cell cell;
  std::vector<std::string> notes;  ///< a sentence for each branch that is gone
};

/// The cell with the resistances of such branches added to r_s.
[[nodiscard]] FoldedCell FoldFastBranches(const Cell& cell);

/// The sum of two resistances: straight lines between the nodes of both.
[[nodiscard]] Resistance<double> Sum(const Resistance<double>& a, const Resistance<double>& b);

}  // namespace lipoid
