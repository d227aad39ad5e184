#pragma once

/// @file
/// Discharges of one campaign that cannot be of one cell in one state: from full to the cut-off, and of charges far
/// apart at one current, or of less charge at a lower one. Tests: tests/identify/logs/unlike_discharges_test.cc.

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

/// In a sentence, the two whose charges are farthest apart: by more than a twentieth of one current, to 3 %, or by more
/// than a tenth where the slower one delivers less, though not below 15 degC; "" where there are none. Discharges that
/// began more than 5 degC apart are not compared.
[[nodiscard]] std::string DoubtAboutDischarges(const std::vector<FullDischarge>& discharges);

}  // namespace lipoid
