#pragma once

/// @file
/// The voltage that a cell would show under a recorded current.
/// Tests: tests/model/battery/prediction_test.cc.

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "model/battery/cell.h"
#include "model/battery/record_stepper.h"
#include "model/core/errors.h"

namespace lipoid {

struct Prediction {
  std::vector<double> voltage_V;       ///< terminal voltage of the pack
  std::vector<double> open_circuit_V;  ///< v_oc times the cells in series
  std::vector<double> soc;             ///< A, a fraction
  /// Of a cell that knows temperature; else empty.
  std::vector<double> temperature_degC;
  std::size_t rows_outside_curve = 0;  ///< rows whose A lies outside the range of v_oc(A)
};

/// How warm a cell is on its way. Only cells that know temperature look at it.
struct Surroundings {
  /// Measured at every row. Where it is empty the temperature is predicted.
  std::span<const double> measured_degC = {};
  std::optional<double> ambient_degC = {};  ///< none: the reference temperature of the cell
  std::optional<double> initial_degC = {};  ///< of the cell at the first row; none: the ambient
};

/// A cell that is relaxed at this state of charge, among its surroundings.
[[nodiscard]] CellModel<double>::State StartAmong(const CellModel<double>& model,
                                                  double initial_soc,
                                                  const Surroundings& surroundings);

/// Terminal voltage, open-circuit voltage and state of charge at every row. Times in s, strictly
/// increasing; currents in A of the whole pack, discharge positive. The cell starts relaxed at
/// initial_soc.
[[nodiscard]] Prediction Predict(const Cell& cell,
                                 std::span<const double> time_s,
                                 std::span<const double> current_A,
                                 Hold hold = Hold::kBackward,
                                 double initial_soc = 1.0,
                                 const Surroundings& surroundings = {});

/// The cell at a row, and the voltage of its pack.
struct PredictedRow {
  double soc;
  double voltage_V;
  const RecordStepper<double>& stepper;
};

/// The same row by row, keeping nothing, for rows that come in blocks.
class RowPredictor {
 public:
  /// The cell must outlive this.
  RowPredictor(const Cell& cell, Hold hold, double initial_soc)
      : cell_(cell), hold_(hold), initial_soc_(initial_soc), model_(cell.Parameters()) {}
  RowPredictor(const RowPredictor&) = delete;
  RowPredictor& operator=(const RowPredictor&) = delete;

  /// visit(k, PredictedRow) for the rows of a block; `surroundings` measured are those of its rows.
  template <class Visit>
  void Rows(std::span<const double> time_s,
            std::span<const double> current_A,
            const Surroundings& surroundings,
            Visit&& visit) {
    Require(time_s.size() == current_A.size(),
            "as many times as currents",
            {{"times", static_cast<double>(time_s.size())},
             {"currents", static_cast<double>(current_A.size())}});
    const auto measured_degC = surroundings.measured_degC;
    Require(measured_degC.empty() || measured_degC.size() == time_s.size(),
            "as many temperatures as times",
            {{"temperatures", static_cast<double>(measured_degC.size())}});
    if (!stepper_) stepper_.emplace(model_, hold_, StartAmong(model_, initial_soc_, surroundings));
    RecordStepper<double>& stepper = *stepper_;
    for (std::size_t k = 0; k < time_s.size(); ++k) {
      const double one_A = current_A[k] / cell_.parallel;
      if (measured_degC.empty()) {
        stepper.Row(time_s[k], one_A);
      } else {
        stepper.Row(time_s[k], one_A, measured_degC[k] + kZeroCelsius_K);
      }
      const double soc = stepper.Soc();
      visit(k, PredictedRow{soc, cell_.series * stepper.Voltage(soc), stepper});
    }
  }

 private:
  const Cell& cell_;
  Hold hold_;
  double initial_soc_;
  CellModel<double> model_;
  std::optional<RecordStepper<double>> stepper_;
};

/// The same of rows that are all there.
template <class Visit>
void PredictRows(const Cell& cell,
                 std::span<const double> time_s,
                 std::span<const double> current_A,
                 Hold hold,
                 double initial_soc,
                 const Surroundings& surroundings,
                 Visit&& visit) {
  RowPredictor(cell, hold, initial_soc)
      .Rows(time_s, current_A, surroundings, std::forward<Visit>(visit));
}

}  // namespace lipoid
