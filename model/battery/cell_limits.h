#pragma once

/// @file
/// How large the numbers of a cell file may be. Tests: tests/model/battery/cell_file_test.cc.

namespace lipoid {

/// The size of any number of a cell in its unit, far beyond any cell: what is computed from several
/// of them stays finite.
inline constexpr double kMostOfACell = 1e12;
/// Of a capacitance, a time constant over a resistance that may be next to nothing.
inline constexpr double kMostCapacitance_F = 1e30;

}  // namespace lipoid
