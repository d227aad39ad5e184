#pragma once

/// @file
/// Trust and profiles as JSON, for --summary and cell files. Tests:
/// tests/identify/trust/trust_report_test.cc, profile_test.cc.

#include "identify/trust/profile.h"
#include "identify/trust/trust.h"
#include "model/core/json.h"

namespace lipoid {

/// The array `parameters`: name, unit, estimate, standard_error, interval_95 [low, high], verdict,
/// with, ... What is not a number is null.
[[nodiscard]] Json TrustedParametersToJson(const TrustReport& report);

/// The object `trust`: sentence, singular_values, combinations, residual_correlation, covariance.
[[nodiscard]] Json TrustToJson(const TrustReport& report);

/// The array `resistance`: soc, after_s, current_A, resistance_Ohm, interval_95.
[[nodiscard]] Json PulseResistancesToJson(const TrustReport& report);

/// The array `profiles`: name, unit, estimate, points [{value, cost, rmse_V}], interval_95 with an
/// end of null where the cost does not rise enough within the points, objective_rise_95,
/// objective_rise_of.
[[nodiscard]] Json ProfilesToJson(const std::vector<Profile>& profiles);

}  // namespace lipoid
