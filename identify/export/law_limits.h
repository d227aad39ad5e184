#pragma once

/// @file
/// What laws poorer than the cell's leave out, in sentences for Exported::cannot_hold.
/// Tests: tests/identify/export/targets_test.cc.

#include <string>
#include <string_view>
#include <vector>

#include "model/export/exported.h"

namespace lipoid {

struct LawTerms {
  int branches = 0;               ///< pairs of resistor and capacitor
  bool resistance_table = false;  ///< resistances over the state of charge
};

/// Gives the request a pack. No target knows temperature or hysteresis: numbers are found and written
/// without them, and compared with the pack as it is.
void SetCell(ExportRequest& request, const Cell& cell);

/// Of a pack that has neither.
inline constexpr std::string_view kNoMoreTerms =
    "Temperature and hysteresis: neither the cell file nor these numbers hold any.";

/// Only what this cell has and such a law has not, of a law that counts charge alone. What SetCell()
/// left out is not named again.
[[nodiscard]] std::vector<std::string> LeftOut(const ExportRequest& request, const LawTerms& law);

/// Whether the branch is next to nothing: its resistance is below a thousandth of the series
/// resistance at every node, or its time constant below shortest_s.
[[nodiscard]] bool IsNegligible(const Cell& cell, const Cell::Branch& branch, double shortest_s);

}  // namespace lipoid
