#pragma once

/// @file
/// The cell as an FMU: co-simulation (lipoid's exact step) and model exchange (the same law as
/// derivatives) of FMI 2.0 ("2", the default) or 3.0 ("3"). One file, a zip archive with
/// modelDescription.xml, C sources for any system and a library for this one, which reads the
/// cell's numbers from the archive's resources: to export needs no compiler, to run needs neither
/// lipoid nor C++.
///
///   inputs       current_A (discharge positive) and power_W of the pack, added up
///   outputs      voltage_V, soc, open_circuit_V, drawn_current_A
///   parameters   series, parallel, initial_soc, series_resistance_scale
///
/// Tests: tests/model/export/fmi_test.cc.

#include "model/export/exported.h"

namespace lipoid {

/// OptionError where the version is another.
[[nodiscard]] Exported ExportFmi(const ExportRequest& request);

}  // namespace lipoid
