#pragma once

/// @file
/// From the logs of a campaign to a cell, by either method, in one call: what `lipoid identify`
/// does for each campaign. Commands, reports and other languages only hand in data and show the
/// result.
///
///   const Campaign campaign = ReadCampaign("campaign.toml");
///   const Identification found = Identify(campaign, LoadCampaign(campaign), {});
///
/// Tests: tests/identify/identification_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/fit_quality.h"
#include "identify/health/flights_alone.h"
#include "identify/health/flights_with_lab.h"
#include "identify/health/health.h"
#include "identify/joint/joint_run.h"
#include "identify/joint/leave_out.h"
#include "identify/stages/staged_run.h"
#include "identify/trust/profile.h"
#include "model/core/json.h"
#include "model/core/run_record.h"

namespace lipoid {

enum class IdentifyMethod { kStaged, kJoint };
constexpr std::array<std::pair<IdentifyMethod, std::string_view>, 2> OptionNames(IdentifyMethod) {
  return {{{IdentifyMethod::kStaged, "staged"}, {IdentifyMethod::kJoint, "joint"}}};
}

struct IdentifyOptions {
  IdentifyMethod method = IdentifyMethod::kJoint;
  StagedOptions staged = {};  ///< the joint method starts from a staged run
  JointOptions joint = {};
  StagedGiven given = {};
  std::vector<std::string> profiled = {};  ///< parameters whose profile is wanted
};

struct Identification {
  Cell cell;  ///< with its uncertainty, from which cells can be drawn
  bool converged = false;
  FitQuality quality;            ///< the verdict on the whole
  TrustReport trust;
  std::vector<std::string>
      not_drawn;  ///< parameters of which cells drawn vary only in what is known
  std::vector<Profile> profiles;
  ExpectedError expected_error;        ///< of a new log of the fitted kinds, from held-out rows
  std::optional<StagedResult> staged;  ///< of the staged method
  std::optional<JointResult> joint;    ///< of the joint one, with the staged run it started from
  std::optional<FlightsAlone> flights_alone;       ///< of a campaign of nothing but flights
  std::optional<FlightsWithLab> flights_with_lab;  ///< of flights beside lab logs
  /// Of flights beside lab logs: against the cell that those gave.
  std::optional<HealthReport> health;
  std::vector<std::string> log_notes;  ///< NotesOnLogs()

  /// Whether the cell can be used: the search converged and the cell describes its logs.
  [[nodiscard]] bool usable() const { return converged && quality.grade != FitGrade::kPoor; }
  /// The first line of every report, and of which logs it is where not of all.
  [[nodiscard]] std::string Verdict() const;
  /// The kinds of logs that the last fit used.
  [[nodiscard]] std::vector<LogKind> fitted_kinds() const;
  /// "pulses" or "discharges" of the staged method, whose errors are of no other logs; else empty.
  [[nodiscard]] std::string fitted_part() const;
  /// Mean error of the pulses (staged), or the mean over all fitted logs of theirs (joint).
  [[nodiscard]] double mean_error_percent() const;
};

/// What was asked, for the run record.
[[nodiscard]] Json StagedOptionsToJson(const StagedOptions& options, const StagedGiven& given);
[[nodiscard]] Json IdentifyOptionsToJson(const IdentifyOptions& options);

/// Throws OptionError for what no campaign can change: a parameter or a profile that is not there.
void CheckIdentifyOptions(const IdentifyOptions& options);

/// Throws LoadError for logs that are not what the campaign says they are, OptionError for options
/// that do not fit them. `progress` is told the stage and the share of the work done.
[[nodiscard]] Identification Identify(const Campaign& campaign,
                                      const std::vector<LoadedLog>& logs,
                                      const IdentifyOptions& options,
                                      const StageProgress& progress = {});

/// The keys of `lipoid identify --summary` (docs/formats.md), but for `cell`, `campaign` and `file`.
[[nodiscard]] Json IdentificationToJson(const Identification& found);

/// What a cell was identified from: the key `campaign` of the summary.
[[nodiscard]] Json CampaignToJson(const Campaign& campaign, const std::vector<LoadedLog>& logs);

/// The cell then carries how it was made: `run` with these options and, as metrics, the report.
void AddRunRecord(Identification& found,
                  const IdentifyOptions& options,
                  Json report,
                  RunRecord run);

}  // namespace lipoid
