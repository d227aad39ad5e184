#pragma once

/// @file
/// All logs at once: the staged method gives the start and stays for comparison; then one fit of
/// every log together, with resistances that depend on the state of charge where the data say so.
///
/// alpha is a mere capacity reference: scaling it rescales the axis of v_oc(A) and moves no
/// voltage. Convention: A = 0 where v_oc reaches the cut-off. The fit starts with the charge of the
/// low-rate log and is moved to the convention by its own curve, which is the low-rate voltage
/// corrected for drop and lag. The method, its derivation and its limits: docs/joint.md. Tests:
/// tests/identify/joint/joint_run_test.cc.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "identify/constant_current_validation.h"
#include "identify/joint/capacity_reference.h"
#include "identify/joint/heat_fit.h"
#include "identify/joint/joint_choice.h"
#include "identify/joint/reference_curve.h"
#include "identify/stages/open_circuit_voltage_from_rests.h"
#include "identify/stages/staged_run.h"

namespace lipoid {

struct JointResult {
  Cell cell;
  bool converged = false;
  StagedResult staged;
  JointChoice choice;
  double alpha_C = 0.0;
  std::string alpha_source;              ///< "cut-off", "given", or what the staged method took
  std::string alpha_doubt;               ///< why it is not that of the cut-off; empty where it is
  bool alpha_not_found = false;          ///< it is where the search for it ends
  double rmse_V = 0.0;                   ///< weighted, of the fit
  int evaluations = 0;                   ///< of rates
  std::vector<LogErrors> fitted;         ///< every log that took part, all of its rows
  std::vector<LogErrors> fitted_staged;  ///< the same by the staged cell
  std::vector<LogErrors> validation;
  std::vector<ConstantCurrentErrors> constant_current;  ///< with the time until cut-off
  std::vector<std::string> cautions;
  double wall_s = 0.0;  ///< of the joint part and the staged one together
  /// For standard errors: what the fit saw, with the final capacity reference.
  JointLogs logs;
  JointSetup setup;
  std::map<std::string, double> fixed;                      ///< what the user held
  std::map<std::string, std::pair<double, double>> bounds;  ///< and what the user allowed
  std::optional<HeatFit> heat;  ///< none: the temperature of the cell is not predicted
  CutoffPoint cutoff;           ///< among the nodes of v_oc; found only where it fixed alpha
  double start_soc = 1.0;       ///< of all logs, where they start alike
  /// Whether a v_oc(A) that is held is that of these logs.
  std::optional<CurveMove> held_curve = {};
  /// What one of these logs delivered before its voltage was below the cut-off, over start_soc: alpha
  /// is no less, since v_oc lies above the voltage of a discharge. 0: not known.
  double least_alpha_C = 0.0;
  /// Standard deviation of a charge that was counted: of the noise of the current, where that was the
  /// instrument's own.
  double counting_C = 0.0;

  /// What fixed alpha where the fit would have moved it away from the rests.
  std::optional<AlphaOfRests> alpha_of_rests = {};

  /// The axis of the cell against that of the fit.
  [[nodiscard]] FitAxis Axis() const {
    return {.alpha_ratio = setup.axis_follows_alpha ? 1.0 : alpha_C / setup.alpha_C,
            .start_soc = start_soc};
  }
};

/// Throws LoadError for logs that are not what the campaign says they are, OptionError for
/// knowledge that the joint method cannot use.
[[nodiscard]] JointResult IdentifyJoint(const Campaign& campaign,
                                        const std::vector<LoadedLog>& logs,
                                        const StagedOptions& staged_options = {},
                                        const JointOptions& options = {},
                                        const StagedGiven& given = {},
                                        const StageProgress& progress = {});

/// v_oc over the charge of the low-rate log, by that log alone, which no wrong start of another one
/// has bent; none where there is no such log, or another curve was given.
[[nodiscard]] std::optional<OpenCircuitVoltage> LowRateCurve(const StagedResult& staged,
                                                             const std::vector<LoadedLog>& logs);

}  // namespace lipoid
