#pragma once

/// @file
/// Between which states of charge the open-circuit voltage of a cell is known, and what is extrapolated
/// beyond them. Flights alone show the part of v_oc(A) that was flown; beyond it the curve goes on with
/// its end slope, which may be flat where a pack is nearly full. Tests:
/// tests/model/battery/curve_range_test.cc.

#include <string>

namespace lipoid {

struct Cell;

/// So far beyond its ends a curve is as well known as within; as far above an empty cell it may end.
inline constexpr double kNearCurve_soc = 0.05;

/// Whether v_oc is known between these states of charge; below 0 and above 1 nothing is asked.
[[nodiscard]] bool KnowsCurve(const Cell& cell, double lowest_soc, double highest_soc);

/// What is extrapolated where the cell is at these states of charge, as a sentence. "": nothing.
[[nodiscard]] std::string DoubtAboutCurve(const Cell& cell, double lowest_soc, double highest_soc);

}  // namespace lipoid
