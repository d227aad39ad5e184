#pragma once

/// @file
/// How far to believe parameters, for people: a table, and the sentence under it.

#include <string>

#include "identify/identification.h"

namespace lipoid {

/// Estimate, standard error, 95 % interval and verdict of every parameter; then the sentence, and
/// what the intervals take as exact where that is not empty.
[[nodiscard]] std::string TrustText(const TrustReport& report, const std::string& exact = "");

/// What the logs know best, first of all: the charge, what a pulse test would measure, and the
/// error that a new log is to be expected to have.
[[nodiscard]] std::string KnownText(const Identification& found);

/// "identified", or "only with r_1, beta".
[[nodiscard]] std::string VerdictText(const QuantityTrust& quantity);

}  // namespace lipoid
