#pragma once

/// @file
/// Walks a cell through the stages of a test, row by row until its cut-off: what a synthetic log
/// records, and what a planned one would. Tests: tests/identify/synthesis/synthesize_test.cc,
/// tests/identify/trust/experiment_plan_test.cc.

#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <string>

#include "identify/synthesis/decimal_step.h"
#include "identify/synthesis/protocols.h"
#include "model/battery/prediction.h"
#include "model/core/errors.h"
#include "model/core/stop.h"

namespace lipoid {

/// One row: the current of the pack, the voltage of one cell.
struct WalkedRow {
  std::int64_t index = 0;
  double time_s = 0.0;
  double current_A = 0.0;
  double voltage_V = 0.0;
  const RecordStepper<double>& stepper;
};

/// visit(WalkedRow) for the row at rest with which the log begins and for every row after it, to the
/// first at or below the cut-off or to the end of the last cycle. OptionError where the cell never
/// gets there, is there at once, or makes more rows than that.
template <class Visit>
void WalkPlan(const Cell& cell,
              const TestPlan& plan,
              const DecimalStep& sampling,
              Hold hold,
              std::int64_t most_rows,
              Visit&& visit) {
  const auto rows_of = [&](const TestStage& stage) {
    return std::isinf(stage.length_s) ? most_rows + 1 : sampling.Count(stage.length_s);
  };
  const CellModel<double> model(cell.Parameters());
  RecordStepper<double> stepper(
      model, hold, StartAmong(model, 1.0, {.ambient_degC = plan.ambient_degC}));
  constexpr std::int64_t kLook = 4096;  // rows that take less than a millisecond
  std::size_t stage = 0;
  int cycle = 1;
  std::int64_t rows_left = rows_of(plan.stages[0]);
  for (std::int64_t row = 0;; ++row) {
    if (row % kLook == 0) StopIfAsked();
    const double time_s = sampling.Times(row);
    const double current_A = row == 0 ? 0.0 : plan.stages[stage].current_A * cell.parallel;
    stepper.Row(time_s, current_A / cell.parallel);  // as whoever reads it will
    const double voltage_V = stepper.Voltage();
    visit(WalkedRow{row, time_s, current_A, voltage_V, stepper});
    if (cell.series * voltage_V <= cell.series * cell.cutoff_V) {
      if (row > 1) return;
      throw OptionError(
          fmt::format("{}: the full cell is at its cut-off of {} V at once, at {} A; take a lower "
                      "rate",
                      plan.file,
                      cell.cutoff_V,
                      current_A));
    }
    if (stepper.state().delivered_C > 3.0 * cell.alpha_C()) {
      throw OptionError(
          fmt::format("{}: the cell never reaches its cut-off of {} V; give it another v_oc(A) or "
                      "cut-off",
                      plan.file,
                      cell.cutoff_V));
    }
    if (row == most_rows) {
      throw OptionError(
          fmt::format("{}: more than {} rows; take a longer sampling_s or shorter rests",
                      plan.file,
                      most_rows));
    }
    if (row == 0 || --rows_left > 0) continue;
    do {
      if (++stage == plan.stages.size()) {
        if (cycle++ == plan.cycles) return;
        stage = 0;
      }
      rows_left = rows_of(plan.stages[stage]);
    } while (rows_left == 0);
  }
}

/// Why such a test gives no log of pulses that identify takes, and what to do; "" where it does.
[[nodiscard]] std::string WhyNoPulses(const Cell& cell,
                                      const TestPlan& plan,
                                      const DecimalStep& sampling);

}  // namespace lipoid
