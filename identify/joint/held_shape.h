#pragma once

/// @file
/// What an earlier cell lends to the fit of the same cell at another age, so that a short test is
/// enough: the curves over the state of charge and the nonlinear unknowns stay, and only alpha, beta
/// and the resistances are fitted.
///
/// v_oc(A), dv_oc/dT(A) and M(A) are held as they are, on an axis that follows alpha. A table of
/// resistances is fitted, but what is smooth is its ratio to that of the earlier cell: where the logs
/// say nothing it keeps that shape. Time constants, i_0, activation energies and gamma are held.
/// Tests: tests/identify/joint/held_shape_test.cc.

#include <map>
#include <string>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

/// Of the resistance when new: a cold and old cell has some times of it, no cell has much less.
inline constexpr double kLeastResistanceOfNew = 1.0 / 3.0;
inline constexpr double kMostResistanceOfNew = 6.0;
/// Age takes charge and brings none; a third more is another cell.
inline constexpr double kMostCapacityOfNew = 4.0 / 3.0;
inline constexpr double kLeastCapacityOfNew = 1.0 / 3.0;

struct HeldShape {
  std::string source;  ///< a file or a name, for reports
  Cell cell;           ///< one cell, in amperes and volts of its own

  /// Nodes of every resistance: those of the table that has most.
  [[nodiscard]] std::vector<double> ResistanceNodes() const;
  /// The resistance of table t at A, in the order of JointLayout: r_s, r_1 .. r_n, r_ct. No less than
  /// a twentieth of its largest value, so that a ratio to it is finite.
  [[nodiscard]] double Resistance(int t, double soc) const;
  /// The nonlinear unknowns that are held, by name.
  [[nodiscard]] std::map<std::string, double> Rates() const;
  /// "v_oc(A), tau_1, tau_2, i_0": for people.
  [[nodiscard]] std::vector<std::string> Names() const;
};

}  // namespace lipoid
