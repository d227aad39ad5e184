#pragma once

/// @file
/// How far to believe the parameters of a joint run. Every unknown takes part, the nodes of v_oc(A)
/// and of the tables too: what is uncertain in the curve makes resistances uncertain, as it should.
/// Linear unknowns have the rows of the fit as their sensitivities; those of the rates are the exact
/// slopes of the same sweep. Tables are asked at three states
/// of charge, r_s(0.2), r_s(0.5), r_s(0.8); alpha by where v_oc reaches the cut-off. What stands at
/// a bound is held. docs/joint.md, docs/verdicts.md.
/// Tests: tests/identify/joint/joint_trust_test.cc.

#include "identify/joint/joint_run.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// The fitted rows of each log, with the sensitivities of the rates that were searched (in the
/// order of `rates`), then of the linear unknowns of JointLayout with rises of v_oc for its nodes.
struct JointSensitivities {
  std::vector<std::string> rates;
  std::vector<FittedRows> logs;
};
[[nodiscard]] JointSensitivities FindSensitivities(const JointResult& result);

[[nodiscard]] TrustReport AssessJoint(const JointResult& result, const TrustOptions& options = {});

}  // namespace lipoid
