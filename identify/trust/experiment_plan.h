#pragma once

/// @file
/// What an experiment would tell, before the lab is booked: the standard errors of beta, r_s, r_j,
/// tau_j that the pulses of a protocol would give for a cell like this one, under noise that is
/// assumed. The same sandwich as for a fit (trust.h), at the parameters of the cell; alpha and
/// v_oc(A) are taken as known. Tests: tests/identify/trust/experiment_plan_test.cc.

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "identify/logs/record.h"
#include "identify/synthesis/decimal_step.h"
#include "identify/synthesis/protocols.h"
#include "identify/trust/trust.h"
#include "model/battery/cell.h"

namespace lipoid {

struct PlannedNoise {
  double white_V = 2e-4;         ///< independent from row to row
  double coloured_V = 5e-4;      ///< slow errors of cell and instrument
  double correlation_s = 300.0;  ///< of the slow ones
  double temperature_K = 0.1;    ///< of a thermometer, independent from row to row
};

struct PlannedExperiment {
  /// Why identify would not take its logs (plan_walk.h); then nothing else is known. "": it would.
  std::string refused = {};
  double current_A = 0.0;
  double duration_s = 0.0;  ///< to cut-off
  std::size_t rows = 0;
  TrustReport trust;
  /// Of the cell in any row; NaN where temperature takes no part.
  double coldest_degC = std::numeric_limits<double>::quiet_NaN();
  double warmest_degC = std::numeric_limits<double>::quiet_NaN();
};

/// The pulses of the protocol with these options, on this cell, to its cut-off. OptionError where
/// they do not suit each other. Resistances over the state of charge count with their value at half
/// charge.
[[nodiscard]] PlannedExperiment PlanExperiment(const Cell& cell,
                                               const SynthesisOptions& options,
                                               const PlannedNoise& noise);

/// How the rows of such a plan follow one another; OptionError where no decimal says it.
[[nodiscard]] DecimalStep SamplingOf(const SynthesisOptions& options);

/// What a test would record of one cell without noise, pulses to the last row that is not below the
/// cut-off; with temperatures where the plan has one.
[[nodiscard]] Record RecordOfPlan(const Cell& cell,
                                  const TestPlan& plan,
                                  const DecimalStep& sampling);

/// The cell as rows every sampling_s can see it: the resistance of a branch whose time constant is
/// below half of that counts with r_s.
[[nodiscard]] Cell AsSampled(const Cell& cell, double sampling_s);

/// That branch j counts with r_s for that reason, where it does.
[[nodiscard]] std::optional<std::string> TooFastForPlan(const Cell& cell,
                                                        std::size_t j,
                                                        double sampling_s);

/// The terms of the cell that are in no plan, by name; with `constants` a resistance is one number.
[[nodiscard]] std::vector<std::string> TermsLeftOut(const Cell& cell, bool constants);

/// What of the cell a plan with rows every sampling_s leaves out, in words.
[[nodiscard]] std::vector<std::string> LeftOutOfPlan(const Cell& cell, double sampling_s);

}  // namespace lipoid
