#pragma once

/// @file
/// What a person may ask of the joint method, checked before any log is read. Tests:
/// tests/identify/joint/joint_run_test.cc.

#include "identify/joint/joint_choice.h"
#include "identify/stages/staged_run.h"

namespace lipoid {

/// Throws OptionError for knowledge that the joint method cannot use, whatever the logs are.
void CheckJointRequest(const StagedGiven& given, const JointOptions& options, bool diffusion);

}  // namespace lipoid
