#pragma once

/// @file
/// A prediction whose state of charge goes where no curve was measured, or where no cell can go. Tests:
/// tests/tools/predict_test.cc, tests/python/test_cell.py.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <string>

#include "model/core/counted.h"

namespace lipoid {

/// Whether a current charges a cell that began at `first_soc` to more than any holds.
[[nodiscard]] inline bool IsOverfull(double first_soc, double highest_soc) {
  constexpr double kMore = 0.1;  // than full, or than the cell began with
  return highest_soc > std::max(1.0, first_soc) + kMore;
}

/// One sentence; empty where all rows lie on the curve.
[[nodiscard]] inline std::string DoubtAboutCurve(std::size_t rows_outside) {
  if (rows_outside == 0) return "";
  return fmt::format(
      "{} outside the soc that v_oc(A) was made for: it goes on with its end slope there",
      Counted(rows_outside, "row"));
}

}  // namespace lipoid
