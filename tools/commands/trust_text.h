#pragma once

/// @file
/// How far to believe parameters, for people: a table, and the sentence under it.

#include <string>

#include "identify/trust/trust.h"

namespace lipoid {

/// Estimate, standard error, 95 % interval and verdict of every parameter; then the sentence, and
/// what the intervals take as exact where that is not empty.
[[nodiscard]] std::string TrustText(const TrustReport& report, const std::string& exact = "");

/// "identified", or "only with r_1, beta".
[[nodiscard]] std::string VerdictText(const QuantityTrust& quantity);

}  // namespace lipoid
