#pragma once

/// @file
/// A cell as it is at one temperature. Tests: tests/model/battery/temperature_test.cc.

#include "model/battery/cell.h"

namespace lipoid {

/// A cell that knows no temperature and shows the voltages that this one shows while it has this
/// temperature: resistances times their factors, beta over the root of its own, v_oc with its slope.
/// A beta beyond 1 stays 1. A cell that knows no temperature comes back as it is.
[[nodiscard]] Cell AtOneTemperature(Cell cell, double temperature_degC);

}  // namespace lipoid
