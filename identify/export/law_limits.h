#pragma once

/// @file
/// What laws poorer than the cell's leave out, in sentences for Exported::cannot_hold.
/// Tests: tests/identify/export/targets_test.cc.

#include <string>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

struct LawTerms {
  int branches = 0;               ///< pairs of resistor and capacitor
  bool resistance_table = false;  ///< resistances over the state of charge
};

/// Only what this cell has and such a law has not, of a law that counts charge alone.
[[nodiscard]] std::vector<std::string> LeftOut(const Cell& cell, const LawTerms& law);

/// Whether the branch is next to nothing: its resistance is below a thousandth of the series
/// resistance at every node, or its time constant below shortest_s.
[[nodiscard]] bool IsNegligible(const Cell& cell, const Cell::Branch& branch, double shortest_s);

}  // namespace lipoid
