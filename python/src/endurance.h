#pragma once

/// @file
/// How long a vehicle flies on a pack.

#include <nanobind/nanobind.h>

namespace lipoid::python {

namespace nb = nanobind;

void AddEndurance(nb::module_& module);

}  // namespace lipoid::python
