#pragma once

/// @file
/// Stretches of time without rows. Tests: tests/identify/logs/gaps_test.cc.

#include <vector>

#include "identify/logs/log.h"

namespace lipoid {

/// Intervals longer than ten times the usual one on either side. A logger that changes its rate at
/// a new step leaves none: the interval fits one of its sides.
[[nodiscard]] std::vector<Gap> FindGaps(const std::vector<double>& time_s);

}  // namespace lipoid
