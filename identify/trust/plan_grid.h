#pragma once

/// @file
/// Variations of one experiment, combined with one another: what `lipoid plan` shows. Of a cell that
/// knows temperature, or where an ambient temperature is given, an experiment is the whole protocol of
/// synthesis/protocols.h (campaign_plan.h), and each is followed by what a second temperature would
/// add to it; else the pulses alone (experiment_plan.h).
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
  /// Of the campaign; empty: the reference temperature of a cell that knows one, and no temperature
  /// for any other.
  std::vector<double> ambient_degC = {};
  /// Those that would be added; empty: kSecondBelow_K below the coldest.
  std::vector<double> second_degC = {};
  PlannedNoise noise = {};
};

inline constexpr double kSecondBelow_K = 25.0;
/// How much is done at a second temperature: nothing, the same pulses to cut-off, or the first of
/// them.
enum class SecondPulses { kNone, kAll, kOne };

struct PlannedVariation {
  double rate_C = 0.0;
  double pulse_s = 0.0;
  double rest_s = 0.0;
  double sampling_s = 0.0;
  PlannedExperiment plan;
  std::vector<double> ambient_degC = {};  ///< empty: temperature takes no part
  SecondPulses second = SecondPulses::kNone;
  double second_degC = 0.0;  ///< where there are some
};

struct PlanGridResult {
  std::vector<PlannedVariation> variations;  ///< by rate, pulse, rest and sampling
  std::vector<std::string> left_out;         ///< of the cell, in words
  bool temperature = false;                  ///< whether it takes part
  bool temperature_assumed = false;          ///< energies and heat of the cell are typical values
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
