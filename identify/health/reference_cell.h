#pragma once

/// @file
/// What a pack is compared with: the cell it was when new, and how far a pack in the air may be from
/// it before a flight is looked at.
///
/// A cell that was identified in the lab is known; a shipped one carries the typical curve of its
/// chemistry and little else, and its spread is that between cells of the chemistry. Spreads are
/// standard deviations, of logarithms where the quantity is positive. They are judgement, not measured, but
/// for what the cell's own `uncertainty` adds to them. Tests:
/// tests/identify/health/reference_cell_test.cc.

#include <optional>

#include "model/battery/cell.h"

namespace lipoid {

/// A spread that holds what it is of.
inline constexpr double kHeldSpread = 1e-6;

struct ReferenceSpread {
  double log_capacity = 0.5;  ///< of the capacity now over that when new: age is what is asked for
  double log_series = 0.7;
  double log_branches = 0.7;
  double log_beta = 0.2;
  double log_time_constants = 0.2;
  double log_warming = 0.4;
  double curve_V = 0.005;      ///< of v_oc at one state of charge
  double curve_length = 0.15;  ///< over which its error changes, in state of charge
  double kinks_V = 0.0;  ///< of what v_oc has besides, over kKinksLength: kinks, and rounded values
};

inline constexpr double kKinksLength = 0.05;  ///< in state of charge

struct ReferenceCell {
  Cell cell;             ///< one cell, of the capacity of all that are in parallel
  bool typical = false;  ///< the curve is that of a chemistry, and resistances say nothing
  ReferenceSpread spread;
};

/// One cell as large as all `parallel` of the pack: `capacity_Ah` is the capacity of the new pack,
/// none: what the cell file says. Resistances go with one over the capacity.
[[nodiscard]] ReferenceCell MakeReference(const Cell& cell,
                                          int parallel,
                                          std::optional<double> capacity_Ah);

/// The cell itself, which has not aged since its identification: what flights beside lab logs are held
/// against. Only resistances, and with them time constants, may be others than in the lab, because the cell may be colder or warmer: by little
/// where the temperature of the flight is known.
[[nodiscard]] ReferenceCell SameCell(const Cell& cell, bool temperature_known);

}  // namespace lipoid
