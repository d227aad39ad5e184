#pragma once

/// @file
/// The voltage that a cell would show under a recorded current.
/// Tests: tests/model/battery/prediction_test.cc.

#include <cstddef>
#include <span>
#include <vector>

#include "model/battery/cell.h"
#include "model/battery/record_stepper.h"

namespace lipoid {

struct Prediction {
  std::vector<double> voltage_V;       ///< terminal voltage of the pack
  std::vector<double> open_circuit_V;  ///< v_oc(A) times the cells in series
  std::vector<double> soc;             ///< A, a fraction
  std::size_t rows_outside_curve = 0;  ///< rows whose A lies outside the range of v_oc(A)
};

/// Terminal voltage, open-circuit voltage and state of charge at every row. Times in s, strictly
/// increasing; currents in A of the whole pack, discharge positive. The cell starts relaxed at
/// initial_soc.
[[nodiscard]] Prediction Predict(const Cell& cell,
                                 std::span<const double> time_s,
                                 std::span<const double> current_A,
                                 Hold hold = Hold::kBackward,
                                 double initial_soc = 1.0);

}  // namespace lipoid
