#pragma once

/// @file
/// How old a pack is, by flights on it.

#include <nanobind/nanobind.h>

namespace lipoid::python {

namespace nb = nanobind;

void AddHealth(nb::module_& module);

}  // namespace lipoid::python
