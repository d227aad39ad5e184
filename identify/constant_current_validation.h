#pragma once

/// @file
/// A cell against logs of constant currents: the voltage, row by row, and the time until cut-off.
/// Tests: tests/identify/constant_current_validation_test.cc.

#include <limits>
#include <vector>

#include "identify/logs/load_campaign.h"
#include "identify/stages/discharge_times.h"
#include "identify/validation.h"

namespace lipoid {

/// A cell that has not reached its cut-off after so many times the measured time never does.
inline constexpr double kLongestDischarge = 3.0;

struct ConstantCurrentErrors {
  LogErrors voltage;        ///< of the whole log
  double current_A = 0.0;   ///< of one cell: charge over time, from switch-on to cut-off
  double measured_s = 0.0;  ///< from switch-on to cut-off
  /// At current_A, from the relaxed start of the log until the predicted voltage reaches the
  /// cut-off (TimeToCutoff); NaN where it does not within kLongestDischarge measured_s.
  double predicted_s = std::numeric_limits<double>::quiet_NaN();
  double error_percent = std::numeric_limits<double>::quiet_NaN();  ///< of the time
  /// Under the same load the voltage rises above the cut-off again, as that of a cold cell which warms. How long until
  /// its first fall, or whether it gets there at all, is then a question of millivolts: looked for where the time is off.
  bool comes_back = false;
};

/// Of each constant-current log of the campaign, in its order. `measured` are their discharges in
/// the same order, where they are known already: else they are found, and a log that is no
/// discharge to the cell's cut-off is a LoadError.
[[nodiscard]] std::vector<ConstantCurrentErrors> ValidateConstantCurrents(
    const Cell& cell,
    const std::vector<LoadedLog>& logs,
    const std::vector<DischargeTime>& measured = {});

}  // namespace lipoid
