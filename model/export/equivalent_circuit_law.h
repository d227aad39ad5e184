#pragma once

/// @file
/// The equivalent circuit of the package thevenin and of Simscape's battery blocks: a state of
/// charge that counts charge alone, a table of v_oc, resistances over the state of charge,
///
///   soc'  = -i/(3600 capacity)
///   v_cj' = (r_j(soc) i - v_cj)/tau_j
///   v     = v_oc(soc) - r_0(soc) i - sum_j v_cj
///
/// Tables are straight lines and hold their end values. Volts, amperes and ohms of one cell.
/// Tests: tests/model/export/laws_test.cc.

#include <vector>

#include "model/export/curve_nodes.h"
#include "model/export/exported.h"

namespace lipoid {

struct EquivalentCircuit {
  double capacity_Ah = 0.0;
  CurveNodes open_circuit;  ///< with what lies beyond 0 and 1 (ExtendedNodesOf)
  std::vector<double> soc;  ///< nodes of all resistances
  std::vector<double> series_Ohm;
  struct Branch {
    std::vector<double> resistance_Ohm;
    double time_constant_s = 0.0;  ///< > 0
  };
  std::vector<Branch> branches;
};

/// The voltage in every row of a mission of one cell. `drawn_Ah` as of ChargeDrawn_Ah().
[[nodiscard]] std::vector<double> EquivalentCircuitVoltage(const EquivalentCircuit& circuit,
                                                           const ExportMission& mission,
                                                           const std::vector<double>& drawn_Ah);

/// A row over which the state of charge changes by more than this is taken in several steps, each
/// of which takes r_j in its middle.
inline constexpr double kLargestSocStep = 0.002;

}  // namespace lipoid
