#pragma once

/// @file
/// identify() and validate() for Python.

#include <nanobind/nanobind.h>

namespace lipoid::python {

namespace nb = nanobind;

void AddIdentification(nb::module_& module);

}  // namespace lipoid::python
