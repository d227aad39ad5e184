#pragma once

/// @file
/// A given v_oc(A): a CSV with the columns soc (a fraction) and voltage_V, joined by straight
/// lines, or the curve of a cell file. Tests: tests/tools/identify_test.cc.

#include <string>

#include "model/battery/open_circuit_voltage.h"

namespace lipoid {

/// Rows in any order of soc. LoadError with line and column where a row is wrong, a soc is repeated
/// or reads like a percentage, or there are fewer than two rows; and where the curve is one in mV or
/// of a pack.
[[nodiscard]] OpenCircuitVoltage ReadOpenCircuitVoltageFile(const std::string& file);

}  // namespace lipoid
