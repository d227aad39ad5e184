#pragma once

/// @file
/// fly() for Python.

#include <nanobind/nanobind.h>

namespace lipoid::python {

void AddFlights(nanobind::module_& module);

}  // namespace lipoid::python
