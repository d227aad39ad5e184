#pragma once

/// @file
/// The thesis' method from logs to cell: discharge times -> alpha, beta; low rate -> v_oc(A);
/// pulses -> beta again, r_s, r_j, c_j. A missing kind of log is not the end: what was done instead
/// is said, and stands in the cell file. Logs come as records of one cell (packs already divided).
/// Tests: tests/identify/stages/staged_run_test.cc.

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "identify/constant_current_validation.h"
#include "identify/joint/held_shape.h"
#include "identify/logs/load_campaign.h"
#include "identify/stages/discharge_times.h"
#include "identify/stages/open_circuit_voltage_fit.h"
#include "identify/stages/open_circuit_voltage_from_rests.h"
#include "identify/stages/pulse_fit.h"
#include "identify/stages/staged_trust.h"
#include "model/battery/cell.h"

namespace lipoid {

struct StagedOptions {
  DischargeTimesOptions discharge_times;
  OcvFitOptions open_circuit_voltage;
  PulseFitOptions pulses;
  LevenbergMarquardtOptions solver;
};

/// What the user gives instead of leaving it to be found.
struct StagedGiven {
  std::optional<double> alpha_C;
  std::optional<OpenCircuitVoltage> open_circuit_voltage;
  std::string open_circuit_voltage_source;  ///< a file, for the record
  GivenParameters parameters;
  /// An earlier cell of the same kind whose shapes are held; the joint method only.
  std::shared_ptr<const HeldShape> reference = {};

  /// "held as given: alpha = 100000 C, beta = 0.2 s^-1/2"; empty
  /// where nothing is.
  [[nodiscard]] std::string HeldInWords() const;
};

struct StagedResult {
  Cell cell;
  bool converged = false;
  std::optional<DischargeTimesResult> discharge_times;
  std::optional<OcvFitResult> open_circuit_voltage;  ///< none without a low-rate log
  std::optional<OcvFromRests> from_rests;            ///< v_oc where neither log nor curve is there
  std::optional<PulseFitResult> pulses_beta_held;    ///< (4.60); none where beta is given or absent
  PulseFitResult pulses;                             ///< (4.61)
  LogKind fitted_kind = LogKind::kPulses;            ///< of the logs that stage 3 used
  TrustReport trust;                                 ///< how far to believe the parameters
  StartValues start;
  double alpha_C = 0.0;
  std::string alpha_source;               ///< "discharge-times", "low-rate-charge", "given",
                                          ///< "pulse-charge", "nominal-capacity"
  double low_rate_charge_C = 0.0;         ///< 0 without such a log
  double low_rate_offset_V = 0.0;         ///< by which the low-rate log lies below v_oc
  std::vector<std::string> done_instead;  ///< for a kind of log that is missing
  std::vector<std::string> cautions;      ///< what the method leaves out, where it matters here
  std::vector<LogErrors> validation;      ///< of the logs that took no part
  /// Of these logs the stages use the times alone, unless they stand in for pulses.
  std::vector<ConstantCurrentErrors> constant_current;
  double wall_s = 0.0;
};

/// What stage 3 fits, as stages 1 and 2 left it. The logs must outlive it.
struct PulseTask {
  VoltageSweep sweep;
  StartValues data;
  double beta_start_per_sqrt_s = 0.0;
  StagedResult found;  ///< of stages 1 and 2
};

/// Called with the name of the stage that begins and the share of the work done.
using StageProgress = std::function<void(std::string_view stage, double share)>;

/// Called once stages 1 and 2 are done, with what they found: other work on it may begin.
using BeforePulses = std::function<void(const StagedResult&)>;

/// Throws LoadError for logs that are not what the campaign says they are.
[[nodiscard]] StagedResult IdentifyStaged(const Campaign& campaign,
                                          const std::vector<LoadedLog>& logs,
                                          const StagedOptions& options = {},
                                          const StagedGiven& given = {},
                                          const StageProgress& progress = {},
                                          const BeforePulses& before_pulses = {});

/// The same up to where the pulses are to be fitted: for those who fit them otherwise.
[[nodiscard]] PulseTask PreparePulses(const Campaign& campaign,
                                      const std::vector<LoadedLog>& logs,
                                      const StagedOptions& options = {},
                                      const StagedGiven& given = {});

/// An alpha_source for a sentence: one has the name of a kind of log that may be none of the campaign's.
[[nodiscard]] std::string AlphaSourceInWords(std::string_view source);

}  // namespace lipoid
