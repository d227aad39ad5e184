#pragma once

/// @file
/// A number that is known up to a standard error, and values drawn from it. Tests:
/// tests/model/statistics/uncertain_test.cc.

#include <algorithm>

#include "model/core/options.h"
#include "model/statistics/normal_noise.h"

namespace lipoid {

struct Uncertain {
  double value = 0.0;
  double standard_error = 0.0;  ///< >= 0; 0: the value is known

  [[nodiscard]] bool known() const { return standard_error == 0.0; }

  /// A normal value about this one; beyond the range the nearest that is valid. Takes one number of
  /// the noise in any case, so that what is drawn next does not depend on what is known.
  [[nodiscard]] double Draw(NormalNoise& normal, const Range& valid) const {
    return std::clamp(value + standard_error * normal(), valid.lo, valid.hi);
  }
};

}  // namespace lipoid
