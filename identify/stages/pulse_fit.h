#pragma once

/// @file
/// Stage 3: beta, r_s and the branches from pulses, with alpha and v_oc(A) held.
///
///   (4.60)  r_s, r_j, c_j with beta held
///   (4.61)  the same and beta, in [0, 1]
///
/// minimize the squared voltage error over all rows. It is the joint problem (joint_fit.h) with
/// constant resistances, the curve given and nothing smoothed: r_s and r_j follow exactly from beta
/// and tau_j, which are searched over a grid on a coarse view of the logs, so that the optimum is
/// found from the best of many starts. Then all rows decide. A capacitance that is given or bounded
/// holds r_j = tau_j/c_j. Tests: tests/identify/stages/pulse_fit_test.cc.

#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "identify/stages/start_values.h"
#include "identify/stages/voltage_sweep.h"
#include "model/battery/error_metrics.h"
#include "model/battery/ranges.h"
#include "model/core/options.h"

namespace lipoid {

struct PulseFitOptions {
  int branches = 1;
  int terms = kUsualModes;
  bool tail = kUsualTail;
  bool diffusion = true;
  int starts = 4;

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("branches", self.branches, Range{0.0, 5.0}, "number of resistor-capacitor branches");
    v("terms", self.terms, kModeNumbers, "number of diffusion modes, M in (4.46)");
    v("tail",
      self.tail,
      Names{},
      "whether the diffusion modes beyond M count by their steady value; the thesis leaves them "
      "out");
    v("diffusion",
      self.diffusion,
      Names{},
      "whether charge diffuses; if false beta is infinite, the plain equivalent circuit");
    v("starts",
      self.starts,
      Range{1.0, 100.0},
      "number of starts that are refined on the condensed logs");
  }
};

struct PulseFitResult {
  SweepParameters parameters;
  JointSolution solution;                          ///< the same, as the fit found it
  Termination termination = Termination::kNotRun;  ///< of the final fit on all rows
  std::string message;                             ///< why that ended
  int evaluations = 0;                             ///< of the sweep over all rows
  int starts = 0;                                  ///< compared on the coarse view
  std::vector<std::string> at_bound;  ///< names; r_j: the branch is gone, or merged into r_s
  std::vector<std::string> fixed;     ///< names that were held
  std::map<std::string, std::pair<double, double>> bounds;  ///< that were given
  ErrorMetrics errors;                                      ///< over all rows, (4.56)-(4.58)
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

/// Where the rates of a fit to these logs are searched; `data` are their start values.
[[nodiscard]] FitScales PulseFitScales(const VoltageSweep& sweep, const StartValues& data);

/// The setup of the sweep says how the diffusion is modelled; options.branches how many branches
/// there are. Throws OptionError where `knowledge` names a parameter that is not there or
/// contradicts itself.
[[nodiscard]] PulseFitResult FitPulses(const VoltageSweep& sweep,
                                       const PulseFitStart& start,
                                       const PulseFitOptions& options = {},
                                       const LevenbergMarquardtOptions& solver = {},
                                       const GivenParameters& knowledge = {});

}  // namespace lipoid
