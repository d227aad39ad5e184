#pragma once

/// @file
/// A cell against a measured log: how far the predicted voltage is off, over all rows and over
/// those above 10 % state of charge (below, the steep end of v_oc(A) makes any error of charge
/// large). Tests: tests/identify/validation_test.cc.

#include "identify/logs/record.h"
#include "model/battery/cell.h"
#include "model/battery/error_metrics.h"
#include "model/battery/prediction.h"

namespace lipoid {

struct Validation {
  ErrorMetrics all;
  ErrorMetrics above_10_soc;
  Prediction prediction;
};

/// The record is that of the pack the cell's series and parallel make; it starts relaxed at
/// initial_soc.
[[nodiscard]] Validation Validate(const Cell& cell, const Record& record, double initial_soc = 1.0);

/// The state of charge at which the pack rests with this voltage. OptionError where v_oc(A) never
/// has it.
[[nodiscard]] double SocAtRestVoltage(const Cell& cell, double voltage_V);

}  // namespace lipoid
