#pragma once

/// @file
/// What thevenin and simscape say of their equivalent circuit: the same fit, the same numbers.

#include <optional>
#include <string>
#include <vector>

#include "identify/export/circuit_fit.h"

namespace lipoid {

/// Fits and fills in all but the files; none where no circuit was found.
[[nodiscard]] std::optional<EquivalentCircuit> ReportCircuit(const ExportRequest& request,
                                                             Exported& exported);

/// Numbers with all their digits: "0.1, 0.25".
[[nodiscard]] std::string NumberList(const std::vector<double>& values);

}  // namespace lipoid
