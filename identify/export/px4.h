#pragma once

/// @file
/// The target px4: the numbers of PX4's battery estimator as a parameter file of QGroundControl.
/// Law: model/export/px4_law.h. Tests: tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// Fits empty and charged voltage and the resistance; the capacity is the cell's usable one.
[[nodiscard]] Exported ExportPx4(const ExportRequest& request);

}  // namespace lipoid
