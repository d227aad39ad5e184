#pragma once

/// @file
/// How far to believe parameters, for people: a table and the one sentence.

#include <string>

#include "identify/trust/trust.h"

namespace lipoid {

/// Estimate, standard error, 95 % interval and verdict of every parameter; then the sentence.
[[nodiscard]] std::string TrustText(const TrustReport& report);

}  // namespace lipoid
