#pragma once

/// @file
/// A curve v_oc(A) of smooth functions over its whole range, by least squares over rows: Chebyshev
/// polynomials, or harmonics whose frequency is found, too.
/// Tests: tests/identify/stages/open_circuit_voltage_fit_test.cc.

#include "identify/stages/curve_rows.h"
#include "model/battery/open_circuit_voltage.h"

namespace lipoid {

[[nodiscard]] OpenCircuitVoltage FitPolynomial(const CurveRows& rows,
                                               const Share& shown,
                                               int degree);

[[nodiscard]] OpenCircuitVoltage FitFourier(const CurveRows& rows,
                                            const Share& shown,
                                            int harmonics);

}  // namespace lipoid
