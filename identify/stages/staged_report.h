#pragma once

/// @file
/// The staged run as JSON: the keys of `lipoid identify --summary`, and the metrics in the cell
/// file. Tests: tests/identify/stages/staged_run_test.cc, tests/tools/identify_test.cc.

#include "identify/stages/staged_run.h"
#include "model/core/json.h"

namespace lipoid {

/// stages.discharge_times, stages.open_circuit_voltage, stages.pulses_beta_held, stages.pulses,
/// validation, constant_current, converged, done_instead, cautions, alpha_C, alpha_source,
/// low_rate_charge_C, alpha_over_low_rate_charge. What does not exist is null.
[[nodiscard]] Json StagedToJson(const StagedResult& result);

[[nodiscard]] Json LogErrorsToJson(const LogErrors& errors);

/// The keys of LogErrorsToJson(), and current_A, measured_s, predicted_s, error_percent; the last
/// two are null where the cell never reaches its cut-off.
[[nodiscard]] Json ConstantCurrentErrorsToJson(const ConstantCurrentErrors& errors);

/// beta, r_s, r_j, c_j (null where r_j is zero), tau_j.
[[nodiscard]] Json SweepParametersToJson(const SweepParameters& parameters, bool diffusion);

}  // namespace lipoid
