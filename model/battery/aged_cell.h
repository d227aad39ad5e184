#pragma once

/// @file
/// A cell that has aged, with less capacity and more resistance, and a cell of another size. Tests:
/// tests/model/battery/aged_cell_test.cc.

#include <string>

#include "model/battery/cell.h"
#include "model/core/options.h"

namespace lipoid {

// What may be asked of it, over that of the cell file.
inline constexpr Range kCapacityShares{0.01, 2.0};
inline constexpr Range kResistanceFactors{0.01, 100.0};
inline constexpr Range kCapacities_Ah{1e-3, 1e5};

/// The cell with `capacity_share` > 0 of its charge and `resistance_factor` > 0 times its
/// resistances: of the series, the branches and the charge transfer. The time constants stay, so
/// that the capacitances of the branches shrink. beta stays, so that diffusion holds back the same
/// charge per ampere. Curves over the state of charge stay where they are. What the file says of
/// its uncertainty no longer holds for it and goes: draw first, age afterwards.
[[nodiscard]] Cell Aged(Cell cell, double capacity_share, double resistance_factor);

/// The same cell `factor` > 0 times as large: at a current that is as many times larger its voltage and
/// its temperature are the same. Its uncertainty goes, as with Aged().
[[nodiscard]] Cell Resized(Cell cell, double factor);

/// A capacity that is given is a nominal one, as that of the cell file is: what to say where this cell
/// delivers another charge than its label names, by which one of another size does too. Empty where the two
/// agree, or where it keeps its size.
[[nodiscard]] std::string DoubtAboutSize(const Cell& cell, double factor);

}  // namespace lipoid
