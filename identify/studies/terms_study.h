#pragma once

/// @file
/// How many diffusion modes are enough? (4.61) fitted with M modes of (4.46), with and without the
/// quasi-static tail. Without it the sum loses the share (pi²/6 - sum_{m<=M} 1/m²)/(pi²/6) of the
/// steady unavailable charge (4.41), which beta and r_s then make up for. What they should be is
/// taken from the most modes with the tail. Tests: tests/identify/studies/terms_study_test.cc.

#include "identify/studies/study.h"

namespace lipoid {

/// rows[]: terms, tail, wall_s, rmse_V, beta_per_sqrt_s, beta_bias_percent, series_resistance_Ohm,
/// series_resistance_bias_Ohm, lost_share_percent. OptionError where the diffusion is switched off.
[[nodiscard]] StudyResult StudyTerms(const StudyInput& input, const StudyProgress& progress);

}  // namespace lipoid
