#pragma once

/// @file
/// Discharges of one campaign that cannot be of one cell in one state: from full to the cut-off at one
/// current, and of charges far apart. Tests: tests/identify/logs/unlike_discharges_test.cc.

#include <string>
#include <vector>

#include "model/core/special_values.h"

namespace lipoid {

/// From full to the cut-off.
struct FullDischarge {
  std::string file;
  double current_A = 0.0;
  double charge_C = 0.0;
  double start_degC = kNaN;  ///< NaN: not known
};

/// In a sentence, the two of one current, to 3 %, whose charges are farthest apart, by more than a
/// twentieth; "" where there are none. Discharges that began more than 5 degC apart are not compared.
[[nodiscard]] std::string DoubtAboutDischarges(const std::vector<FullDischarge>& discharges);

}  // namespace lipoid
