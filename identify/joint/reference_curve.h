#pragma once

/// @file
/// Whether v_oc(A) of an earlier cell, which a fit holds (held_shape.h), is that of the cell in these logs.
/// Age moves it: what one electrode loses shifts its curve against that of the other.
///
/// The fit is asked again, to first order about its solution, with a correction of v_oc(A) as one more
/// unknown: straight lines between nodes a tenth of the charge apart. Alpha, beta and the resistances
/// follow. A correction that takes most of the error away is the curve's: what resistances, branches or
/// noise leave of an error is no function of A alone.
/// Tests: tests/identify/joint/reference_curve_test.cc.

#include <optional>
#include <string>

namespace lipoid {

struct JointResult;

struct CurveMove {
  double rmse_V = 0.0;            ///< weighted, of the fit
  double corrected_rmse_V = 0.0;  ///< the same with the correction
  double largest_V = 0.0;  ///< the correction where it takes most error away, to be added to v_oc
  double soc = 0.0;        ///< where that is

  /// Whether the held curve is not that of these logs.
  [[nodiscard]] bool doubted() const;
};

/// None where nothing is held.
[[nodiscard]] std::optional<CurveMove> MoveOfHeldCurve(const JointResult& result);

/// Why the held curve is not that of these logs; "" where it may be. `source` is whose it is.
[[nodiscard]] std::string DoubtAboutHeldCurve(const std::string& source, const CurveMove& move);

}  // namespace lipoid
