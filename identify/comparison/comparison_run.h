#pragma once

/// @file
/// From the logs of a campaign to a comparison of optimizers, in one call: what `lipoid compare` does.
/// Tests: tests/tools/compare_test.cc, tests/python/test_comparison.py.

#include <string>
#include <vector>

#include "identify/comparison/compare_optimizers.h"
#include "identify/stages/staged_request.h"
#include "model/core/json.h"

namespace lipoid {

/// The optimizers that the thesis compares, by name.
[[nodiscard]] std::vector<std::string> ThesisOptimizers();

/// Each once, in the order named; all of them for the one name "all". OptionError for a name that is
/// not known or stands there twice.
[[nodiscard]] std::vector<const OptimizerEntry*> FindOptimizers(
    const std::vector<std::string>& names);

/// The options of `lipoid compare` and the keywords of lipoid.compare().
struct ComparisonRequest {
  StagedRequest staged = {};
  std::vector<std::string> optimizers = ThesisOptimizers();
  int starts = 0;
  bool time_constants = false;
  ComparisonOptions options = {};
  OptimizerSettings settings = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("optimizers",
      self.optimizers,
      Word{"NAME,NAME,..."},
      "optimizers to compare, or all (`lipoid list optimizers`); by default the thesis' seven");
    v("starts",
      self.starts,
      Range{0, 100000},
      "number of random starts of each optimizer, besides the one that the logs suggest");
    v("time_constants", self.time_constants, Names(), "tau_j as unknowns, instead of c_j");
    StagedRequest::Visit(self.staged, v);
  }

  template <class Visitor>
  void EachGroup(Visitor&& v) {
    v("", options);
    staged.EachGroup(v);
  }

  /// As StagedRequest::Resolve(); OptionError as FindOptimizers().
  void Resolve();
};

struct ComparisonRunResult {
  PulseTask task;  ///< the problem
  Comparison comparison;
};

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
