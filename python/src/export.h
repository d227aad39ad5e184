#pragma once

/// @file
/// export() for Python.

#include <nanobind/nanobind.h>

namespace lipoid::python {

void AddExport(nanobind::module_& module);

}  // namespace lipoid::python
