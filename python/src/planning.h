#pragma once

/// @file
/// plan() and synthesize() for Python: before the lab, and instead of it.

#include <nanobind/nanobind.h>

namespace lipoid::python {

void AddPlanning(nanobind::module_& module);

}  // namespace lipoid::python
