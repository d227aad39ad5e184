#pragma once

/// @file
/// The target thevenin: the YAML file of the Python package thevenin, an equivalent circuit of one
/// cell. Law: model/export/equivalent_circuit_law.h. Tests:
/// tests/identify/export/target_files_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// One or two pairs of resistor and capacitor (request.branches), resistances over the state of
/// charge; v_oc and capacity are the cell's own.
[[nodiscard]] Exported ExportThevenin(const ExportRequest& request);

}  // namespace lipoid
