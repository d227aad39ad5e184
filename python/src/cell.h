#pragma once

/// @file
/// A cell as Python sees it: its file, its voltages, its ensemble.

#include <nanobind/nanobind.h>

#include "model/battery/cell.h"

namespace lipoid::python {

namespace nb = nanobind;

struct PythonCell {
  Cell cell;
};

void AddCells(nb::module_& module);

}  // namespace lipoid::python
