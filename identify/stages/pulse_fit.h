#pragma once

/// @file
/// Stage 3: beta, r_s and the branches from pulses, with alpha and v_oc(A) held.
///
///   (4.60)  r_s, r_j, c_j with beta held
///   (4.61)  the same and beta, in [0, 1]
///
/// minimize the squared voltage error over all rows. Resistances and capacitances are >= 0. Starts
/// come from the data: steps of the current give r_s, relaxations time constants; around them a
/// grid of (beta, tau_j), for each of which r_s and r_j follow by linear least squares, is searched
/// on a coarse view of the logs, so that the optimum is found from the best of many starts. Then
/// all rows decide.
///
/// The solver moves (log beta, r_s, r_j, log tau_j), each of order one, or log c_j
/// (pulse_problem.h). Tests: tests/identify/stages/pulse_fit_test.cc.

#include <limits>
#include <string>
#include <vector>

#include "identify/optimizers/levenberg_marquardt.h"
#include "identify/stages/pulse_problem.h"
#include "identify/stages/start_values.h"
#include "identify/stages/voltage_sweep.h"
#include "model/battery/error_metrics.h"
#include "model/core/options.h"

namespace lipoid {

struct PulseFitOptions {
  int branches = 1;
  int terms = 10;
  bool tail = true;
  bool diffusion = true;
  BranchUnknown branch_unknown = BranchUnknown::kTimeConstant;
  int starts = 4;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("branches", self.branches, Range{0.0, 5.0}, "resistor-capacitor branches");
    v("terms", self.terms, Range{0.0, 1000.0}, "diffusion modes, M in (4.46)");
    v("tail", self.tail, Names{}, "quasi-static share of the modes beyond M; off as in the thesis");
    v("diffusion", self.diffusion, Names{}, "off: beta is infinite, the plain equivalent circuit");
    v("branch_unknown", self.branch_unknown, Names{}, "what the solver moves beside r_j");
    v("starts", self.starts, Range{1.0, 100.0}, "starts that are polished on the coarse view");
  }
};

struct PulseFitResult {
  SweepParameters parameters;
  std::string optimizer = "levenberg-marquardt";
  OptimizationSummary summary;         ///< of the final fit on all rows
  int evaluations = 0;                 ///< of the sweep over all rows
  int starts = 0;                      ///< compared on the coarse view
  std::vector<std::string> at_bound;   ///< names; r_j: the branch is gone, or merged into r_s
  std::vector<std::string> fixed;      ///< names that were held
  ErrorMetrics errors;                 ///< over all rows, (4.56)-(4.58)
  std::size_t rows_outside_curve = 0;  ///< rows whose A lies outside the range of v_oc(A)
  double wall_s = 0.0;
};

/// What a fit starts from.
struct PulseFitStart {
  double beta_per_sqrt_s = 0.2;
  bool hold_beta = false;                     ///< (4.60); else (4.61)
  StartValues data = {};                      ///< of the same records
  const SweepParameters* previous = nullptr;  ///< one more start, for example the answer of (4.60)
  const VoltageSweep* coarse = nullptr;       ///< Condensation::Coarse() of the same; or it is made
};

/// The setup of the sweep says how the diffusion is modelled; options.branches how many branches
/// there are. Throws OptionError where `knowledge` names a parameter that is not there or
/// contradicts itself.
[[nodiscard]] PulseFitResult FitPulses(const VoltageSweep& sweep,
                                       const PulseFitStart& start,
                                       const PulseFitOptions& options = {},
                                       const LevenbergMarquardtOptions& solver = {},
                                       const GivenParameters& knowledge = {});

}  // namespace lipoid
