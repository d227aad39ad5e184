#pragma once

/// @file
/// What a reader must know beside the table of a comparison: that nobody has an answer, and which numbers are no
/// findings. Tests: tests/identify/comparison/compare_optimizers_test.cc, tests/tools/compare_test.cc.

#include <string>
#include <vector>

#include "identify/comparison/compare_optimizers.h"
#include "identify/stages/staged_run.h"

namespace lipoid {

/// Whether v is the capacitance or time constant of a branch whose resistance went to none: nothing tells it.
[[nodiscard]] bool IsOfNoBranch(const OptimizerComparison& result, const PulseVariable& v);

/// Why the best of the runs is no answer: it was stopped before it ended, or fits poorly; "" where it is one.
[[nodiscard]] std::string WhyNoAnswer(const Comparison& comparison);

/// Sentences on numbers that are no findings: at a bound, or of a branch that is slower than any that the logs can
/// show. `decades` are those of the options.
[[nodiscard]] std::vector<std::string> ComparisonCautions(const PulseTask& task,
                                                          const Comparison& comparison,
                                                          double decades);

}  // namespace lipoid
