#pragma once

/// @file
/// Variations of one experiment, combined with one another: what `lipoid plan` shows.
/// Tests: tests/tools/plan_test.cc, tests/python/test_planning.py.

#include <functional>
#include <string>
#include <vector>

#include "identify/trust/experiment_plan.h"
#include "model/core/json.h"

namespace lipoid {

struct PlanGrid {
  std::vector<double> pulse_s = {SynthesisOptions{}.pulse_s};
  std::vector<double> rest_s = {SynthesisOptions{}.rest_s};
  std::vector<double> rate_C = {};  ///< empty: what suits the cell
  std::vector<double> sampling_s = {1.0};
  PlannedNoise noise = {};
};

struct PlannedVariation {
  double rate_C = 0.0;
  double pulse_s = 0.0;
  double rest_s = 0.0;
  double sampling_s = 0.0;
  PlannedExperiment plan;
};

struct PlanGridResult {
  std::vector<PlannedVariation> variations;  ///< by rate, pulse, rest and sampling
  std::vector<std::string> left_out;         ///< of the cell, in words
};

/// OptionError where there are more than kMostVariations, or an experiment does not suit the cell.
inline constexpr std::size_t kMostVariations = 1000;
[[nodiscard]] PlanGridResult PlanVariations(const Cell& cell,
                                            const PlanGrid& grid,
                                            const std::function<void(double)>& progress = {});

/// The keys of `lipoid plan --summary` (docs/formats.md).
[[nodiscard]] Json PlanGridToJson(const Cell& cell,
                                  const PlanGrid& grid,
                                  const PlanGridResult& result);

}  // namespace lipoid
