#pragma once

/// @file
/// The target ns3: attributes of ns-3's RvBatteryModel as a text of its ConfigStore. The model is
/// the diffusion of the cell, (4.46) to (4.48), without the tail of its sum, in mA and minutes; its
/// voltage is a constant, so that the error is one of the state of charge. Tests:
/// tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

inline constexpr int kNs3Terms = 10;  ///< its default: the cost grows with terms times rows squared

/// Fits beta, which makes up for the tail; alpha is the pack's own.
[[nodiscard]] Exported ExportNs3(const ExportRequest& request);

}  // namespace lipoid
