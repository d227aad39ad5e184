#pragma once

/// @file
/// The cell as a SPICE subcircuit, `.subckt NAME p n soc`, in a .lib file: each mode of the
/// diffusion is a capacitor with a resistor, the state of charge a voltage, v_oc(A) and tables
/// behavioural sources. Versions: "ngspice" (the default) and "ltspice", which names tables and
/// conditions otherwise.
///
///   charge q             i into C = alpha                         volts = q/alpha
///   mode m               i into C = alpha/2 beside R = 2/(beta² m² alpha)   volts = 2 u_m/alpha
///   branch j             r_j(A) i into C = tau_j beside 1 Ohm     volts = v_cj
///   thermal state        i² into C = tau_h beside 1 Ohm           volts = h
///   state of charge A    soc0 less the volts of charge and modes, less the tail's i
///
/// Tests: tests/model/export/spice_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// OptionError where the version is another.
[[nodiscard]] Exported ExportSpice(const ExportRequest& request);

}  // namespace lipoid
