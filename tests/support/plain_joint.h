#pragma once

/// @file
/// The joint fit of a known structure, for tests of how far to believe its parameters.

#include "identify/joint/joint_choice.h"

namespace lipoid::test {

/// One branch and constant resistances.
inline constexpr JointOptions kPlainJoint{.branches = 1,
                                          .resistance_nodes = 1,
                                          .self_heating = Presence::kOff,
                                          .charge_transfer = Presence::kOff,
                                          .smoothness = 1e-4};

}  // namespace lipoid::test
