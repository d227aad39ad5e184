#pragma once

/// @file
/// A study does one stage in several ways and puts the answers into a table. Studies are listed in
/// studies.h; each is defined in a file of its own. Tests: tests/identify/studies/.

#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/stages/staged_run.h"
#include "model/core/json.h"

namespace lipoid {

/// What a study works on. The campaign and its logs must outlive the study.
struct StudyInput {
  const Campaign& campaign;
  const std::vector<LoadedLog>& logs;
  StagedOptions options = {};
  StagedGiven given = {};
};

/// A column of the table: the key in JSON and CSV with its unit, and how people see it.
struct StudyColumn {
  std::string_view key;
  std::string_view header;
  double scale = 1.0;  ///< of the number that people see
  int digits = 4;
};

struct StudyResult {
  std::vector<StudyColumn> columns;
  Json rows = Json::array();         ///< one object each, with the keys of the columns
  Json facts = Json::object();       ///< what holds for all rows
  std::vector<std::string> remarks;  ///< sentences for people
};

/// Called with what is being done and the share that is done.
using StudyProgress = std::function<void(std::string_view what, double share)>;

struct Study {
  std::string_view name;
  std::string_view summary;
  StudyResult (*run)(const StudyInput& input, const StudyProgress& progress);
};

/// How many resistor-capacitor branches do the pulses ask for? Figs 4.19-4.21, with a criterion.
/// rows[]: branches, wall_s, mean_error_percent, max_error_percent, rmse_V, free_parameters,
/// information_criterion (above the least), recommended, at_bound, parameters. Facts:
/// recommended_branches, rows, effective_rows.
[[nodiscard]] StudyResult StudyBranches(const StudyInput& input, const StudyProgress& progress);

/// How should v_oc(A) be written? The forms of Tables 4.1-4.3 and their kin.
/// rows[]: form, parameters, wall_s, mean_error_percent, max_error_percent, rmse_V (rows fitted),
/// left_out_mean_error_percent, left_out_max_error_percent, left_out_rmse_V. LoadError without a
/// low-rate log.
[[nodiscard]] StudyResult StudyOcv(const StudyInput& input, const StudyProgress& progress);

/// How many diffusion modes are enough?
/// rows[]: terms, tail, wall_s, rmse_V, beta_per_sqrt_s, beta_bias_percent, series_resistance_Ohm,
/// series_resistance_bias_Ohm, lost_share_percent. OptionError where the diffusion is switched off.
[[nodiscard]] StudyResult StudyTerms(const StudyInput& input, const StudyProgress& progress);

}  // namespace lipoid
