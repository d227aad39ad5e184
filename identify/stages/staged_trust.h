#pragma once

/// @file
/// How far to believe the parameters of the staged method: beta, r_s, r_j, tau_j and c_j by the
/// residuals of stage 3, alpha by those of the discharge times. The intervals of stage 3 take alpha
/// and v_oc(A) as exact, as its fit does. docs/verdicts.md. Tests:
/// tests/identify/stages/staged_trust_test.cc.

#include <optional>

#include "identify/stages/discharge_times.h"
#include "identify/stages/pulse_fit.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// Of what `fit` found in the logs of the sweep. `times` where alpha came from them. Parameters
/// that were given do not appear.
[[nodiscard]] TrustReport AssessStaged(const VoltageSweep& sweep,
                                       const PulseFitResult& fit,
                                       const std::optional<DischargeTimesResult>& times,
                                       const TrustOptions& options = {});

}  // namespace lipoid
