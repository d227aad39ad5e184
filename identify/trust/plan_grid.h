#pragma once

/// @file
/// Variations of one experiment, combined with one another: what `lipoid plan` shows. Of a cell that
/// knows temperature, or where an ambient temperature is given, an experiment is the whole protocol of
/// synthesis/protocols.h (campaign_plan.h), and each is followed by what a second temperature would
/// add to it; else the pulses alone (experiment_plan.h).
/// Tests: tests/tools/plan_test.cc, tests/python/test_identify.py.

#include <array>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "identify/trust/experiment_plan.h"
#include "model/battery/ranges.h"
#include "model/core/json.h"
#include "model/core/option_kinds.h"
#include "model/core/options.h"

namespace lipoid {

struct PlanGrid {
  std::vector<double> pulse_s = {SynthesisOptions{}.pulse_s};
  std::vector<double> rest_s = {SynthesisOptions{}.rest_s};
  std::vector<double> rate_C = {};  ///< empty: what suits the cell
  std::vector<double> sampling_s = {1.0};
  /// Of the campaign; empty: the reference temperature of a cell that knows one, and no temperature
  /// for any other.
  std::vector<double> ambient_degC = {};
  /// Those that would be added; empty: the first of kSecondBelow_K below the coldest at which the cell gives the
  /// pulses.
  std::vector<double> second_degC = {};
  /// Its noise is at least what the fit left of the logs of this cell that is independent from row to row, unless
  /// the slow errors are told.
  PlannedNoise noise = {};
  /// Its slow errors; none: what the fit left of the logs of this cell, where its file says, and at
  /// least those of PlannedNoise.
  std::optional<double> coloured_noise_V = {};

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
      "standard deviation of the voltage's noise that is independent from row to row, V; at least "
      "what the fit of the cell left of its logs, unless the slow errors are given");
    v("coloured_noise_V",
      self.coloured_noise_V,
      Range{0.0, 1e3},
      "standard deviation of slow errors of the voltage, V; by default what the fit of the cell left "
      "of its logs, at least 0.0005");
    v("correlation_s",
      self.noise.correlation_s,
      Range{kTiny, kYear_s},
      "time over which these slow errors are correlated, s");
    v("ambient_degC",
      self.ambient_degC,
      kTemperatures_degC,
      "temperatures of the surroundings in degC: the whole protocol runs at the first, its pulses "
      "at the others too; all belong to one campaign; by default the reference temperature of a "
      "cell that knows one. A cell that knows none gets typical energies");
    v("second_degC",
      self.second_degC,
      kTemperatures_degC,
      "second temperatures in degC: what the same pulses there, or one pulse, would add to the "
      "campaign; by default 25 degC below the coldest ambient temperature, or less where the cell "
      "gives no such pulses there");
    v("temperature_noise_degC",
      self.noise.temperature_K,
      Range{0.0, 100.0},
      "standard deviation of the thermometer's noise that is independent from row to row, degC");
  }
};

/// What tells an energy well, and less down to what tells it at all.
inline constexpr std::array<double, 4> kSecondBelow_K{25.0, 20.0, 15.0, 10.0};
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

/// Where the slow errors of a plan are from.
enum class SlowErrors { kAssumed, kOfFit, kGiven };

constexpr std::array<std::pair<SlowErrors, std::string_view>, 3> OptionNames(SlowErrors) {
  return {{{SlowErrors::kAssumed, "assumed"},
           {SlowErrors::kOfFit, "fit"},
           {SlowErrors::kGiven, "given"}}};
}

struct PlanGridResult {
  std::vector<PlannedVariation> variations;  ///< by rate, pulse, rest and sampling
  std::vector<std::string> left_out;         ///< of the cell and of what was asked for, in words
  std::vector<std::string> terms_left_out;   ///< of the cell, by name
  PlannedNoise noise;                        ///< that the plan assumes
  bool white_of_fit = false;                 ///< and its noise of single rows is from the fit
  SlowErrors slow_errors = SlowErrors::kAssumed;
  bool temperature = false;          ///< whether it takes part
  bool temperature_assumed = false;  ///< energies and heat of the cell are typical values
};

/// OptionError where there are more than kMostVariations, or no experiment suits the cell.
inline constexpr std::size_t kMostVariations = 1000;
[[nodiscard]] PlanGridResult PlanVariations(const Cell& cell,
                                            const PlanGrid& grid,
                                            const std::function<void(double)>& progress = {});

/// The noise that the plan assumes, as a sentence.
[[nodiscard]] std::string NoiseSentence(const PlanGridResult& result);

/// The keys of `lipoid plan --summary` (docs/formats.md).
[[nodiscard]] Json PlanGridToJson(const Cell& cell, const PlanGridResult& result);

}  // namespace lipoid
