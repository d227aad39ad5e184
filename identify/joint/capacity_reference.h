#pragma once

/// @file
/// Where a curve of nodes reaches the cut-off: what fixes alpha (docs/joint.md, 3).
/// Tests: tests/identify/joint/capacity_reference_test.cc.

#include <cstddef>
#include <vector>

#include "identify/joint/joint_fit.h"
#include "identify/joint/joint_log.h"

namespace lipoid {

/// The line through two nodes on which the cut-off lies: between them, or below the lowest one that
/// rows have determined.
struct CutoffPoint {
  double soc = 0.0;
  std::size_t lower = 0;
  std::size_t upper = 0;
  bool extrapolated = false;
  bool found = false;  ///< false: the curve does not rise

  /// d soc/d voltage of the two nodes.
  double per_lower_V = 0.0;
  double per_upper_V = 0.0;
};

/// Below the lowest node the line goes on that rises to the first node at least so much higher in
/// charge: the last segment alone may be flat where hardly a row went.
inline constexpr double kSecantSoc = 0.03;

/// At least two nodes at rising soc, voltages that do not fall.
[[nodiscard]] CutoffPoint FindCutoff(const std::vector<double>& soc,
                                     const std::vector<double>& voltage_V,
                                     double cutoff_V);

/// The same of a solution's v_oc, at those of its nodes that the logs reach.
[[nodiscard]] CutoffPoint CutoffOf(const JointSolution& solution,
                                   const JointLogs& logs,
                                   const JointSetup& setup,
                                   double cutoff_V);

}  // namespace lipoid
