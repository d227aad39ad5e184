#pragma once

/// @file
/// Profiles as JSON, for --summary. Tests: tests/identify/trust/profile_test.cc.

#include <vector>

#include "identify/trust/profile.h"
#include "model/core/json.h"

namespace lipoid {

/// The array `profiles`: name, unit, estimate, points [{value, cost, rmse_V}], interval_95 with an
/// end of null where the cost does not rise enough within the points, objective_rise_95,
/// objective_rise_of.
[[nodiscard]] Json ProfilesToJson(const std::vector<Profile>& profiles);

}  // namespace lipoid
