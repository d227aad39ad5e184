#pragma once

/// @file
/// From the logs of a campaign to a comparison of optimizers, in one call: what `lipoid compare` does.
/// Tests: tests/tools/compare_test.cc, tests/python/test_comparison.py.

#include <string>
#include <vector>

#include "identify/comparison/compare_optimizers.h"
#include "identify/stages/staged_run.h"
#include "model/core/json.h"

namespace lipoid {

struct ComparisonRequest {
  StagedOptions staged = {};
  StagedGiven given = {};
  std::vector<const OptimizerEntry*> optimizers = {};
  OptimizerSettings settings = {};
  ComparisonOptions options = {};
  int starts = 0;               ///< random ones, besides the data's
  bool time_constants = false;  ///< tau_j as unknowns, instead of c_j
};

struct ComparisonRunResult {
  PulseTask task;  ///< the problem
  Comparison comparison;
};

/// The optimizers that the thesis compares, by name.
[[nodiscard]] std::vector<std::string> ThesisOptimizers();

/// Each once, in the order named; all of them for the one name "all". OptionError for a name that is
/// not known or stands there twice.
[[nodiscard]] std::vector<const OptimizerEntry*> FindOptimizers(
    const std::vector<std::string>& names);

/// The logs must outlive the result. LoadError and OptionError as IdentifyStaged(), and where every
/// parameter is held.
[[nodiscard]] ComparisonRunResult RunComparison(const Campaign& campaign,
                                                const std::vector<LoadedLog>& logs,
                                                const ComparisonRequest& request,
                                                const ComparisonProgress& progress = {});

/// The keys of `lipoid compare --summary` (docs/formats.md).
[[nodiscard]] Json ComparisonRunToJson(const Campaign& campaign,
                                       const ComparisonRequest& request,
                                       const ComparisonRunResult& result);

}  // namespace lipoid
