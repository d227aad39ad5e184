#pragma once

/// @file
/// The equivalent circuit that follows a cell best over a mission: for given time constants the
/// voltage is linear in all nodes of all resistances, which are found exactly within their bounds;
/// the time constants are searched (variable projection). v_oc and capacity are the cell's own, so
/// that the circuit is at rest where the cell is. A node that the mission says nothing of is that
/// of its neighbour. Tests: tests/identify/export/circuit_fit_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "identify/export/projected.h"
#include "model/export/equivalent_circuit_law.h"

namespace lipoid {

struct FittedCircuit {
  EquivalentCircuit circuit;
  Projection projection;  ///< of the logarithms of the time constants
};

/// Time constants are at least this; what is faster belongs to the series resistance, and an
/// explicit solver with a step of 0.1 s stays stable.
inline constexpr double kShortestTimeConstant_s = 0.5;

/// The circuit with so many branches, 0 to 2.
[[nodiscard]] FittedCircuit FitCircuit(const SingleCell& one, int branches);

/// The numbers of the cell file in such a circuit, as a user would type them: nominal capacity,
/// series resistance, and those branches that are not next to nothing.
[[nodiscard]] EquivalentCircuit NaiveCircuit(const Cell& cell, int branches);

/// What thevenin and simscape say of their circuit: fits it and fills in all but the files. None
/// where no circuit was found.
[[nodiscard]] std::optional<EquivalentCircuit> ReportCircuit(const ExportRequest& request,
                                                             Exported& exported);

/// Numbers with all their digits: "0.1, 0.25".
[[nodiscard]] std::string NumberList(const std::vector<double>& values);

}  // namespace lipoid
