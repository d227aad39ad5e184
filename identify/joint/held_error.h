#pragma once

/// @file
/// What the error of an earlier cell does to a fit that holds its curve and rates (held_shape.h).
///
/// The earlier cell says how uncertain v_oc(A), its alpha, time constants and the other rates are (key `uncertainty` of
/// its file). Each principal move of these moves the predicted voltages, and the fit follows to first order, as it
/// follows any other error of the voltages: what was 1 % wrong when new is 1 % wrong again, however well the new logs
/// are described. The shape of the resistances is not counted: logs bend it. Tests:
/// tests/identify/joint/held_error_test.cc.

#include <Eigen/Core>

#include "identify/fit/linearized_fit.h"
#include "identify/fit/pulse_resistance.h"

namespace lipoid {

struct JointResult;

/// A column for each move. There are none where nothing is held, or the cell that is does not say how uncertain it is.
struct HeldError {
  Eigen::MatrixXd of_parameters;  ///< of the fit
  Eigen::MatrixXd
      of_resistances;  ///< of the pulse resistances by the curve and the rates themselves, Ohm
};
[[nodiscard]] HeldError FindHeldError(const JointResult& result,
                                      const LinearizedFit& fit,
                                      const PulseQuestion& question);

}  // namespace lipoid
