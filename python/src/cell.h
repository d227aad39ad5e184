#pragma once

/// @file
/// A cell as Python sees it: its file, its voltages, its ensemble.

#include <nanobind/nanobind.h>

#include <string>

#include "model/battery/cell.h"

namespace lipoid::python {

namespace nb = nanobind;

struct PythonCell {
  Cell cell;
  std::string sha256 = {};  ///< of the file that it was read from; "": of none
};

/// The cell behind an argument: lipoid.Cell or what it wraps; null where it is something else.
[[nodiscard]] const Cell* CellBehind(nb::handle argument);

void AddCells(nb::module_& module);

}  // namespace lipoid::python
