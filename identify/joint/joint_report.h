#pragma once

/// @file
/// A joint run as JSON. Keys: docs/formats.md. Tests: tests/identify/joint/joint_run_test.cc.

#include "identify/joint/joint_run.h"
#include "identify/trust/trust.h"
#include "model/core/json.h"

namespace lipoid {

[[nodiscard]] Json JointToJson(const JointResult& result, const TrustReport& trust);

}  // namespace lipoid
