#pragma once

/// @file
/// A cell of which everything is known in the head.

#include "model/battery/cell.h"

namespace lipoid::test {

/// v_oc from 3 V to 4 V over 1000 C, and nothing else.
inline Cell ChargeCounter() {
  Cell cell;
  cell.capacity_Ah = 1000.0 / 3600.0;
  cell.open_circuit_voltage = OpenCircuitVoltage::Linear({0.0, 1.0}, {3.0, 4.0});
  return cell;
}

}  // namespace lipoid::test
