#pragma once

/// @file
/// Currents whose noise is the instrument's own.
///
/// A current that truly wavers takes the voltage with it: from row to row of one level dv = -r di. Where the
/// voltage does not follow, the noise is that of the measurement, and a fit that takes it for a current finds
/// fast branches that smooth it in place of resistances. What flowed is then the mean of the level. Tests:
/// tests/identify/joint/steady_current_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/logs/load_campaign.h"

namespace lipoid {

struct SteadyCurrents {
  std::vector<LoadedLog> logs;     ///< of the campaign; some have the means of their levels
  std::vector<std::string> files;  ///< of those some
  double noise_A = 0.0;            ///< standard deviation of a row, the most of any of them
  double counting_C = 0.0;         ///< standard deviation of the charge of a log, the most of any

  [[nodiscard]] std::string Said() const;
};

/// None where no log that takes part in the fit has such noise, or it is too small to matter beside that of
/// the voltage.
[[nodiscard]] std::optional<SteadyCurrents> TakeOutCurrentNoise(const std::vector<LoadedLog>& logs);

}  // namespace lipoid
