#pragma once

/// @file
/// Profiles for people: the interval in one line, and a plot of characters under it.

#include <string>
#include <vector>

#include "identify/trust/profile.h"

namespace lipoid {

/// Of each parameter its values with bars, as long as the cost rises over its least; a mark where
/// 95 % end, and one at the estimate. Lines of at most 60 columns.
[[nodiscard]] std::string ProfilesText(const std::vector<Profile>& profiles);

}  // namespace lipoid
