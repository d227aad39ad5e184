#pragma once

/// @file
/// Variations of one experiment, combined with one another: what `lipoid plan` shows.
/// Tests: tests/tools/plan_test.cc, tests/python/test_planning.py.

#include <functional>
#include <string>
#include <vector>

#include "identify/trust/experiment_plan.h"
#include "model/core/json.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid {

struct PlanGrid {
  std::vector<double> pulse_s = {SynthesisOptions{}.pulse_s};
  std::vector<double> rest_s = {SynthesisOptions{}.rest_s};
  std::vector<double> rate_C = {};  ///< empty: what suits the cell
  std::vector<double> sampling_s = {1.0};
  PlannedNoise noise = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    constexpr double kTiny = 1e-6;
    constexpr double kYear_s = 3.2e7;
    v("pulse_s", self.pulse_s, Range{kTiny, kYear_s}, "length of a pulse, s");
    v("rest_s", self.rest_s, Range{0.0, kYear_s}, "rest after each pulse, s");
    v("rate_C",
      self.rate_C,
      Range{kTiny, 1e4},
      "C-rate of the pulses; by default one that suits the cell");
    v("sampling_s", self.sampling_s, Range{kTiny, 1e6}, "time between rows, s");
    v("voltage_noise_V",
      self.noise.white_V,
      Range{0.0, 1e3},
      "standard deviation of the voltage's noise that is independent from row to row, V");
    v("coloured_noise_V",
      self.noise.coloured_V,
      Range{0.0, 1e3},
      "standard deviation of slow errors of the voltage, V");
    v("correlation_s",
      self.noise.correlation_s,
      Range{kTiny, kYear_s},
      "time over which these slow errors are correlated, s");
  }
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
