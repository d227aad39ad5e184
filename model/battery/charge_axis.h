#pragma once

/// @file
/// A cell whose curves were measured over charge, over the state of charge of another alpha.
/// Tests: tests/model/battery/charge_axis_test.cc.

#include "model/battery/cell.h"

namespace lipoid {

/// Moves every curve over the state of charge so that it keeps its charge from a start:
///
///   start - A' = (start - A) ratio,
///
/// where ratio > 0 is the alpha the curves are over by the one that they shall be over. Those of
/// hysteresis have as many e-folds over a charge as before. alpha itself is left alone.
void MoveChargeAxis(Cell& cell, double start_soc, double ratio);

}  // namespace lipoid
