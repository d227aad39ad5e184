#pragma once

/// @file
/// The target gazebo: the SDF element of a LinearBatteryPlugin. Law: model/export/gazebo_law.h.
/// Tests: tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// Fits e0, e1, resistance and smoothing; the capacity is the cell's usable one.
[[nodiscard]] Exported ExportGazebo(const ExportRequest& request);

}  // namespace lipoid
