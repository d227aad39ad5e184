#pragma once

/// @file
/// v_oc(A) as straight lines between nodes, for programs that read a table.
/// Tests: tests/model/export/laws_test.cc.

#include <vector>

#include "model/battery/open_circuit_voltage.h"
#include "model/battery/resistance.h"

namespace lipoid {

struct CurveNodes {
  std::vector<double> soc;  ///< strictly increasing
  std::vector<double> voltage_V;
};

/// The nodes of a linear curve are its own; of another curve there are as many as keep the straight
/// lines within kCurveTolerance_V of it.
inline constexpr double kCurveTolerance_V = 1e-5;
[[nodiscard]] CurveNodes NodesOf(const OpenCircuitVoltage& curve);

/// The same lines as a curve, which goes on beyond its ends with the slopes of `curve`: its own where
/// that is linear.
[[nodiscard]] OpenCircuitVoltage StraightLines(const OpenCircuitVoltage& curve);

/// The same with a node `beyond` before the first and after the last one, on the end slopes: for
/// programs that hold the end value instead.
inline constexpr double kBeyondCurve = 0.5;  // in states of charge
[[nodiscard]] CurveNodes ExtendedNodesOf(const OpenCircuitVoltage& curve,
                                         double beyond = kBeyondCurve);

/// How far the first and last line of a table go on where the iterations of a solver may go far.
inline constexpr double kFarBeyondCurve = 10.0;
/// A table of resistances that goes on so far with its end values, as they do.
[[nodiscard]] Resistance<double> FarExtended(Resistance<double> table);

}  // namespace lipoid
