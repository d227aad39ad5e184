#pragma once

/// @file
/// A cell that has aged: less capacity, more resistance. Tests: tests/model/battery/aged_cell_test.cc.

#include "model/battery/cell.h"

namespace lipoid {

/// The cell with `capacity_share` > 0 of its charge and `resistance_factor` > 0 times its
/// resistances: of the series, the branches and the charge transfer. The time constants stay, so
/// that the capacitances of the branches shrink. beta stays, so that diffusion holds back the same
/// charge per ampere. Curves over the state of charge stay where they are. What the file says of
/// its uncertainty no longer holds for it and goes: draw first, age afterwards.
[[nodiscard]] Cell Aged(Cell cell, double capacity_share, double resistance_factor);

}  // namespace lipoid
