#pragma once

/// @file
/// The target ardupilot: a frame model (JSON) for SITL's option --model and a parameter file. Law:
/// model/export/ardupilot_law.h. Tests: tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// Fits full voltage, capacity and resistance; writes the frame's three battery keys, into the
/// frame of request.into_text where there is one. LoadError where that is no frame.
[[nodiscard]] Exported ExportArduPilot(const ExportRequest& request);

}  // namespace lipoid
