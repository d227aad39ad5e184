#pragma once

/// @file
/// The voltage that a cell would show under a recorded current.
/// Tests: tests/model/battery/prediction_test.cc.

#include <cstddef>
#include <span>
#include <vector>

#include "model/battery/cell.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

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

/// The same row by row, keeping nothing: visit(k, soc, voltage_V).
template <class Visit>
void PredictRows(const Cell& cell,
                 std::span<const double> time_s,
                 std::span<const double> current_A,
                 Hold hold,
                 double initial_soc,
                 Visit&& visit) {
  Require(time_s.size() == current_A.size(),
          "as many times as currents",
          {{"times", static_cast<double>(time_s.size())},
           {"currents", static_cast<double>(current_A.size())}});
  const CellModel<double> model(cell.Parameters());
  RecordStepper<double> stepper(model, hold, model.Relaxed(initial_soc));
  for (std::size_t k = 0; k < time_s.size(); ++k) {
    stepper.Row(time_s[k], current_A[k] / cell.parallel);
    visit(k, stepper.Soc(), cell.series * stepper.Voltage());
  }
}

}  // namespace lipoid
