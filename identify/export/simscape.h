#pragma once

/// @file
/// The target simscape: a MATLAB script with the vectors of the blocks Battery (Table-Based) of
/// Simscape Electrical and Battery Equivalent Circuit of Simscape Battery. The circuit is that of
/// thevenin.h. Tests: tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

[[nodiscard]] Exported ExportSimscape(const ExportRequest& request);

}  // namespace lipoid
