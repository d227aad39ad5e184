#pragma once

/// @file
/// How should v_oc(A) be written? The forms of Tables 4.1-4.3 and their kin, (4.59) fitted to the
/// low-rate log: errors (4.57), (4.58) on the rows that the fit saw, as in the thesis, and on rows
/// that were left out. A is counted with the charge of the log itself: alpha would only stretch the
/// axis. Tests: tests/identify/studies/ocv_study_test.cc.

#include "identify/studies/study.h"

namespace lipoid {

/// rows[]: form, parameters, wall_s, mean_error_percent, max_error_percent, rmse_V (rows fitted),
/// left_out_mean_error_percent, left_out_max_error_percent, left_out_rmse_V. LoadError without a
/// low-rate log.
[[nodiscard]] StudyResult StudyOcv(const StudyInput& input, const StudyProgress& progress);

}  // namespace lipoid
