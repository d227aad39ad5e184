#pragma once

/// @file
/// The cell as a parameter module of PyBaMM's Thevenin model with its diffusion element: a .py file
/// with get_parameter_values(), options and a run of its own. The element
///
///   z_t = z_xx/tau_D on 0 .. 1, z_x(1) = -tau_D i/Q
///
/// has the state of charge A of lipoid's diffusion at its surface where tau_D = pi²/beta² and Q =
/// alpha, with all modes; what remains is the mesh. Its resistances see the mean state of charge
/// instead of A. Tests: tests/model/export/pybamm_test.cc.

#include <vector>

#include "model/export/exported.h"

namespace lipoid {

/// Points of the mesh that the module asks for: PyBaMM's own 20 leave 2 mV.
inline constexpr int kPybammPoints = 100;

/// OptionError where a version is asked for: one module serves all.
[[nodiscard]] Exported ExportPybamm(const ExportRequest& request);

/// Voltage of the pack by PyBaMM's law on a mesh of so many points, solved exactly in its modes. A
/// cell whose self-heating was taken out; a branch's resistance is that at the middle of a row.
[[nodiscard]] std::vector<double> RunPybammLaw(const Cell& cell,
                                               const ExportMission& mission,
                                               int points);

}  // namespace lipoid
