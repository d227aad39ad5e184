#pragma once

/// @file
/// What an experiment would tell, before the lab is booked: the standard errors of beta, r_s, r_j,
/// tau_j that the pulses of a protocol would give for a cell like this one, under noise that is
/// assumed. The same sandwich as for a fit (trust.h), at the parameters of the cell; alpha and
/// v_oc(A) are taken as known. Tests: tests/identify/trust/experiment_plan_test.cc.

#include <string>
#include <vector>

#include "identify/synthesis/protocols.h"
#include "identify/trust/trust.h"
#include "model/battery/cell.h"

namespace lipoid {

struct PlannedNoise {
  double white_V = 2e-4;       ///< independent from row to row
  double coloured_V = 5e-4;    ///< slow errors of cell and instrument
  double correlation_s = 300.0;  ///< of the slow ones
};

struct PlannedExperiment {
  double current_A = 0.0;
  double duration_s = 0.0;  ///< to cut-off
  std::size_t rows = 0;
  TrustReport trust;
};

/// The pulses of the protocol with these options, on this cell, to its cut-off. OptionError where
/// they do not suit each other. Resistances over the state of charge count with their value at half
/// charge.
[[nodiscard]] PlannedExperiment PlanExperiment(const Cell& cell,
                                               const SynthesisOptions& options,
                                               const PlannedNoise& noise);

/// The cell as rows every sampling_s can see it: the resistance of a branch whose time constant is
/// below half of that counts with r_s.
[[nodiscard]] Cell AsSampled(const Cell& cell, double sampling_s);

/// What of the cell a plan with rows every sampling_s leaves out, in words.
[[nodiscard]] std::vector<std::string> LeftOutOfPlan(const Cell& cell, double sampling_s);

}  // namespace lipoid
