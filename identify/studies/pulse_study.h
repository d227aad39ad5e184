#pragma once

/// @file
/// What the studies of stage 3 share: alpha, v_oc(A) and the logs of a campaign, from which the
/// pulses are then fitted in several ways.

#include <string>

#include "identify/stages/pulse_fit.h"
#include "identify/stages/staged_run.h"
#include "identify/studies/study.h"

namespace lipoid {

class PulseStudy {
 public:
  /// Runs the stages before, and stage 3 once without branches for its start. LoadError for logs
  /// that are not what the campaign says they are.
  explicit PulseStudy(const StudyInput& input);

  /// The logs of stage 3 with so many modes.
  [[nodiscard]] VoltageSweep Sweep(int terms, bool tail) const;
  /// From the data's start, and from `previous` too where it is not null.
  [[nodiscard]] PulseFitResult Fit(const VoltageSweep& sweep,
                                   int branches,
                                   const SweepParameters* previous) const;
  /// v_b - v^_b of every row, log by log.
  [[nodiscard]] std::vector<std::vector<double>> Residuals(const VoltageSweep& sweep,
                                                           const SweepParameters& p) const;
  /// Parameters that are free in a fit with so many branches.
  [[nodiscard]] int FreeParameters(const PulseFitResult& fit) const;
  /// beta, r_s, r_1, tau_1, ... by name; a branch without resistance has no time constant (null).
  [[nodiscard]] Json Parameters(const SweepParameters& p) const;

  [[nodiscard]] const StagedResult& before() const { return before_; }
  [[nodiscard]] bool diffusion() const { return input_.options.pulses.diffusion; }

 private:
  const StudyInput& input_;
  StagedResult before_;
};

/// A fit of a study, and how a sentence calls it: "2 branches".
struct NamedFit {
  std::string name;
  const PulseFitResult* fit;
};

/// The fact `converged`, of all fits together, and a remark with those that did not.
void TellWhetherConverged(const std::vector<NamedFit>& fits, StudyResult& result);

}  // namespace lipoid
