#pragma once

/// @file
/// LoadError, OptionError and PreconditionError as the exceptions of lipoid/errors.py.

#include <nanobind/nanobind.h>

namespace lipoid::python {

void AddErrors(nanobind::module_& module);

}  // namespace lipoid::python
