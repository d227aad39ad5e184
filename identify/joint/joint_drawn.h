#pragma once

/// @file
/// What cells are drawn from after a joint fit: the parameters of its cell and the nodes of its
/// tables, as combinations of the unknowns. Tests: tests/identify/joint/joint_drawn_test.cc.

#include "identify/joint/joint_run.h"
#include "identify/trust/trust.h"

namespace lipoid {

/// For TrustOptions::drawn. `quantities` are those that are reported, over the unknowns of
/// LinearizedFit, of which the first `rates` are the rates. alpha takes part where it followed
/// from the curve.
[[nodiscard]] std::vector<NamedCombination> DrawnOfJoint(
    const JointResult& result, const std::vector<TrustedQuantity>& quantities, Eigen::Index rates);

/// Whether the state of charge is counted from alpha alone: every log starts full, or begins at a
/// share of an alpha that was fitted, so that another alpha is another axis for the same curves over
/// charge (docs/joint.md, 3).
[[nodiscard]] bool SocFollowsAlpha(const JointResult& result);

}  // namespace lipoid
