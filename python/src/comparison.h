#pragma once

/// @file
/// compare() and study() for Python.

#include <nanobind/nanobind.h>

namespace lipoid::python {

void AddComparison(nanobind::module_& module);

}  // namespace lipoid::python
