#pragma once

/// @file
/// Results as one page for a browser (tools/report).

#include <nanobind/nanobind.h>

namespace lipoid::python {

namespace nb = nanobind;

void AddReports(nb::module_& module);

}  // namespace lipoid::python
