#pragma once

/// @file
/// How far to believe the parameters of a joint run: a fit at its solution (linearized_fit.h), alpha
/// by where v_oc reaches the cut-off, the total resistance at half charge, and what the choice of the
/// structure adds (structure_spread.h). docs/joint.md, docs/verdicts.md.
/// Tests: tests/identify/joint/joint_trust_test.cc.

#include "identify/joint/joint_run.h"
#include "identify/trust/trust.h"

namespace lipoid {

[[nodiscard]] TrustReport AssessJoint(const JointResult& result, const TrustOptions& options = {});

}  // namespace lipoid
