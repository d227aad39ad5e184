#pragma once

/// @file
/// How many resistor-capacitor branches do the pulses ask for? Figs 4.19-4.21, with a criterion.
///
/// (4.61) is fitted with n = 0 .. 5 branches, each fit starting from the answer of the one before
/// too, so that the cost never rises with n. Among them
///
///   BIC_n = N_e ln(S_n/N) + p_n ln N_e
///
/// is least for the number recommended: S_n the sum of squares over N rows, p_n the free
/// parameters, N_e the number of independent rows that the residuals of the richest fit are worth
/// (effective_rows.h). With N instead of N_e correlated residuals would vote for branches as if
/// every row were news. Tests: tests/identify/studies/branches_study_test.cc.

#include "identify/studies/study.h"

namespace lipoid {

/// rows[]: branches, wall_s, mean_error_percent, max_error_percent, rmse_V, free_parameters,
/// information_criterion (above the least), recommended, at_bound, parameters. Facts:
/// recommended_branches, rows, effective_rows.
[[nodiscard]] StudyResult StudyBranches(const StudyInput& input, const StudyProgress& progress);

}  // namespace lipoid
