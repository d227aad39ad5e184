#pragma once

/// @file
/// Batteries of other programs as cells, so that what people have can fly here and be compared:
///
///   tables       the CSV of the target tables (model/export/cell_tables.h)
///   circuit      an equivalent circuit as JSON, with the keys of the package thevenin (capacity, ocv,
///                R0, R1, C1, ...) or those of PyBaMM ("Cell capacity [A.h]", "R0 [Ohm]", ...)
///   ardupilot    a frame model with maxVoltage, battCapacityAh, refBatRes
///   gazebo       an SDF with a LinearBatteryPlugin
///
/// The format is recognised from the content. What has a law poorer than a cell's becomes the cell
/// that has this law: no diffusion, v_oc as the table or the line that the program has, and where
/// its drop is filtered a branch with this time constant in place of the series resistance. Tests:
/// tests/identify/export/import_cell_test.cc.

#include <optional>
#include <string>
#include <vector>

#include "model/battery/cell.h"

namespace lipoid {

struct ImportOptions {
  std::string name = {};           ///< empty: that of the file's own, or of the file
  std::optional<int> series = {};  ///< of the pack whose numbers the file has
  std::optional<int> parallel = {};
  std::optional<double> capacity_Ah = {};  ///< of a cell, where the file has none
  std::optional<double> cutoff_V = {};     ///< of a cell, where the file has none
};

struct ImportedCell {
  Cell cell;
  std::string format;              ///< "tables", "circuit", "ardupilot", "gazebo"
  std::vector<std::string> notes;  ///< sentences: what was assumed
};

/// LoadError with line and column where the text is none of these, has keys that nobody knows,
/// numbers that are none, or is no battery (capacity 0, full below its cut-off). OptionError for a
/// capacity or cut-off that the file has itself. A full voltage that is none of a lithium-polymer
/// cell is doubted in the first note.
[[nodiscard]] ImportedCell ImportCell(const std::string& text,
                                      const std::string& file,
                                      const ImportOptions& options = {});

}  // namespace lipoid
